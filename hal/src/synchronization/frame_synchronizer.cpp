#include "kinetrace/hal/frame_synchronizer.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "kinetrace/core/config_check.hpp"

namespace kinetrace::hal {
namespace {

// Gains of the alpha-beta filter: a twentieth of the innovation, and critically damped drift (beta = alpha^2 / 2,
// rounded).
constexpr double kOffsetGain = 0.05;
constexpr double kDriftGain = 0.001;
// Crystals differ by at most 100 ppm, free-running sensors by the steps of their dividers.
constexpr double kMaxDrift = 1e-3;
// Partners change beyond half a period; the margin keeps jitter from changing them back at once.
constexpr double kSlipPeriods = 0.6;
constexpr int kStaleUntilRestart = 3;

View other(View view) {
  return view == View::kLeft ? View::kRight : View::kLeft;
}

std::size_t index(View view) {
  return static_cast<std::size_t>(view);
}

}  // namespace

Status SyncConfig::validate() const {
  constexpr std::int64_t kMaxPeriod_ns = 1'000'000'000'000;
  return first_failure(
      {check_range<std::int64_t>("period_ns", period_ns, 2, kMaxPeriod_ns),
       check_range<std::int64_t>("tolerance_ns", tolerance_ns, 1, std::max<std::int64_t>(period_ns / 2, 1))});
}

SyncFrame FrameSynchronizer::Stream::pop() noexcept {
  assert(count > 0);
  const SyncFrame first = waiting[0];
  std::copy(waiting.begin() + 1, waiting.begin() + static_cast<std::ptrdiff_t>(count), waiting.begin());
  --count;
  return first;
}

void FrameSynchronizer::Stream::remember(std::int64_t time_ns) noexcept {
  if (remembered == kRemembered) {
    std::copy(times_ns.begin() + 1, times_ns.end(), times_ns.begin());
    --remembered;
  }
  times_ns[remembered++] = time_ns;
}

std::int64_t FrameSynchronizer::offset_ns() const noexcept {
  return coarse_offset_ns_ + std::llround(offset_ns_);
}

double FrameSynchronizer::predicted_offset_ns(std::int64_t left_time_ns) const noexcept {
  const std::int64_t since_ns = offset_time_ns_ ? left_time_ns - *offset_time_ns_ : 0;
  return offset_ns_ + drift_ * static_cast<double>(since_ns);
}

double FrameSynchronizer::innovation_ns(const SyncFrame& left, const SyncFrame& right) const noexcept {
  return static_cast<double>(right.time_ns - left.time_ns - coarse_offset_ns_) - predicted_offset_ns(left.time_ns);
}

void FrameSynchronizer::drop(View view, const SyncFrame& frame, SyncDrop::Reason reason) noexcept {
  assert(drop_count_ < kMaxDrops);
  drops_[drop_count_++] = {view, frame, reason};
  counters_.unpaired[index(view)] += reason == SyncDrop::Reason::kStale ? 0 : 1;
  counters_.stale[index(view)] += reason == SyncDrop::Reason::kStale ? 1 : 0;
}

std::optional<SyncDrop> FrameSynchronizer::next_drop() noexcept {
  if (drop_count_ == 0) {
    return std::nullopt;
  }
  const SyncDrop first = drops_[0];
  std::copy(drops_.begin() + 1, drops_.begin() + static_cast<std::ptrdiff_t>(drop_count_), drops_.begin());
  --drop_count_;
  return first;
}

// A frame that is not later than the last one is stale. Exceptions, which show a jump of the clock: its number is new
// and its time is earlier by more than jitter, or too many stale frames in a row.
bool FrameSynchronizer::is_stale(Stream& stream, const SyncFrame& frame) noexcept {
  if (!stream.last || frame.time_ns > stream.last->time_ns) {
    stream.stale_in_a_row = 0;
    return false;
  }
  const bool is_new = frame.sequence > stream.last->sequence;
  const bool went_back = frame.time_ns < stream.last->time_ns - config_.period_ns;
  return !(is_new && went_back) && ++stream.stale_in_a_row < kStaleUntilRestart;
}

void FrameSynchronizer::restart(View view) noexcept {
  Stream& restarted = stream(view);
  while (restarted.count > 0) {
    drop(view, restarted.pop(), SyncDrop::Reason::kReset);
  }
  restarted.remembered = 0;
  restarted.stale_in_a_row = 0;
  ++counters_.clock_jumps;
}

void FrameSynchronizer::forget(View view) noexcept {
  stream(view) = Stream{};
}

void FrameSynchronizer::add(View view, const SyncFrame& frame) noexcept {
  Stream& own = stream(view);
  if (is_stale(own, frame)) {
    drop(view, frame, SyncDrop::Reason::kStale);
    return;
  }
  if (own.last && frame.time_ns <= own.last->time_ns) {
    restart(view);
  }
  if (own.count == kWaiting) {
    drop_front(view);
  }
  own.waiting[own.count++] = frame;
  own.last = frame;
  own.remember(frame.time_ns);
  ++own.since_pair;
  if (own.since_pair >= kRelockAfter && stream(other(view)).since_pair >= kRelockAfter) {
    relock();
  }
}

std::optional<SyncPair> FrameSynchronizer::next_pair() noexcept {
  Stream& left = stream(View::kLeft);
  Stream& right = stream(View::kRight);
  const auto tolerance_ns = static_cast<double>(config_.tolerance_ns);
  while (left.count > 0 && right.count > 0) {
    const double innovation = innovation_ns(left.front(), right.front());
    const bool next_right_is_nearer =
        right.count > 1 && std::abs(innovation_ns(left.front(), right.waiting[1])) < std::abs(innovation);
    const bool next_left_is_nearer =
        left.count > 1 && std::abs(innovation_ns(left.waiting[1], right.front())) < std::abs(innovation);
    if (innovation < -tolerance_ns || next_right_is_nearer) {
      drop_front(View::kRight);
    } else if (innovation > tolerance_ns || next_left_is_nearer) {
      drop_front(View::kLeft);
    } else {
      const SyncPair pair{left.pop(), right.pop()};
      ++counters_.pairs;
      left.since_pair = 0;
      right.since_pair = 0;
      learn(pair);
      return pair;
    }
  }
  return std::nullopt;
}

void FrameSynchronizer::learn(const SyncPair& pair) noexcept {
  const double innovation = innovation_ns(pair.left, pair.right);
  const std::int64_t step_ns = offset_time_ns_ ? pair.left.time_ns - *offset_time_ns_ : 0;
  offset_ns_ = predicted_offset_ns(pair.left.time_ns) + kOffsetGain * innovation;
  if (step_ns > 0) {
    drift_ = std::clamp(drift_ + kDriftGain * innovation / static_cast<double>(step_ns), -kMaxDrift, kMaxDrift);
  }
  offset_time_ns_ = pair.left.time_ns;
  const auto period_ns = static_cast<double>(config_.period_ns);
  if (std::abs(offset_ns_) > kSlipPeriods * period_ns) {
    offset_ns_ -= std::copysign(period_ns, offset_ns_);
    ++counters_.slips;
  }
}

// Differences of remembered left times and the right times, modulo the period: if all agree, they are the offset.
void FrameSynchronizer::relock() noexcept {
  Stream& left = stream(View::kLeft);
  Stream& right = stream(View::kRight);
  left.since_pair = 0;
  right.since_pair = 0;
  const std::int64_t newest_ns = right.times_ns[right.remembered - 1] - left.times_ns[left.remembered - 1];
  const std::int64_t apart_ns = newest_ns - coarse_offset_ns_;
  const std::int64_t coarse_offset_ns =
      std::llabs(apart_ns) > kJumpPeriods * config_.period_ns ? newest_ns : coarse_offset_ns_;
  const auto period_ns = static_cast<double>(config_.period_ns);
  // Sorts the whole array, whose size is a compile-time constant: unused elements are infinite and sort last.
  std::array<double, kRemembered> differences_ns{};
  differences_ns.fill(std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < left.remembered; ++i) {
    const auto reference = static_cast<double>(newest_ns - coarse_offset_ns);
    const auto difference =
        static_cast<double>(right.times_ns[right.remembered - 1] - left.times_ns[i] - coarse_offset_ns);
    differences_ns[i] = reference + std::remainder(difference - reference, period_ns);
  }
  std::sort(differences_ns.begin(), differences_ns.end());
  const double middle = differences_ns[left.remembered / 2];
  const auto tolerance_ns = static_cast<double>(config_.tolerance_ns);
  if (differences_ns[left.remembered - 1] - middle > tolerance_ns || middle - differences_ns[0] > tolerance_ns) {
    return;
  }
  coarse_offset_ns_ = coarse_offset_ns;
  offset_ns_ = std::remainder(middle, period_ns);
  drift_ = 0.0;
  offset_time_ns_.reset();
  ++counters_.relocks;
}

}  // namespace kinetrace::hal

#include "kinetrace/hal/sync_monitor.hpp"

#include <algorithm>
#include <cmath>

#include "kinetrace/core/config_check.hpp"
#include "kinetrace/core/quantiles.hpp"
#include "monitoring/patch_matcher.hpp"

namespace kinetrace::hal {
namespace {

constexpr int kMinMatches = 8;
// In pixels of the full images. Good pairs have a median residual of 0.1 px, at most 0.3 px.
constexpr double kMinAsyncResidual_px = 0.25;
constexpr double kMuchBetter = 0.5;
// Ten times the error of a good match: the sign of such a disparity is certain.
constexpr double kSurelyShifted_px = 1.0;
// For pairs with skipped frames in between: maximum distance in frames, minimum image motion in rows per frame, and
// residual in frames that counts as out of step.
constexpr int kMaxApart = 3;
constexpr double kMinMotion_px = 0.75;
constexpr double kOutOfStepFrames = 0.6;

}  // namespace

Status SyncMonitorConfig::validate() const {
  return first_failure({check_range("sync.interval_frames", interval_frames, 2, 1000),
                        check_range("sync.max_disparity_px", max_disparity_px, 16, kMaxDisparity_px)});
}

void SyncMonitor::carve(int width_px, int height_px, Arena& arena, Storage& storage) {
  for (auto* pair : {&storage.now, &storage.before}) {
    for (MutableGrayView& image : *pair) {
      image = take_image<std::uint8_t>(arena, width_px / 2, height_px / 2);
    }
  }
}

std::size_t SyncMonitor::required_bytes(const SyncMonitorConfig& /*config*/, int width_px, int height_px) {
  return measure_bytes([&](Arena& arena) {
    Storage storage;
    carve(width_px, height_px, arena, storage);
  });
}

Result<SyncMonitor> SyncMonitor::create(const SyncMonitorConfig& config, int width_px, int height_px, Arena& arena) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  Storage storage;
  carve(width_px, height_px, arena, storage);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "the arena does not hold the sync monitor; enlarge the memory budget");
  }
  return SyncMonitor(config, storage);
}

SyncMonitor::Look SyncMonitor::next_look() const noexcept {
  const std::int64_t place = pairs_ % config_.interval_frames;
  if (place >= config_.interval_frames - 2) {
    return place == config_.interval_frames - 1 ? Look::kNow : Look::kBefore;
  }
  return pairs_ % 2 == 1 && report_.measurements < kEarlyLooks ? Look::kEarly : Look::kNone;
}

bool SyncMonitor::process(const RectifiedPair& pair) noexcept {
  const Look wanted = next_look();
  ++pairs_;
  if (wanted == Look::kNone) {
    return false;
  }
  if (wanted == Look::kBefore) {
    prepare_patches(pair.left, storage_.before[0]);
    prepare_patches(pair.right, storage_.before[1]);
    before_index_ = pair.frame_index;
    return false;
  }
  const Residual same = look(pair);
  if (wanted == Look::kEarly) {
    return true;
  }
  report_.frames_apart = static_cast<int>(std::min<std::int64_t>(pair.frame_index - before_index_, kMaxApart + 1));
  if (report_.frames_apart >= 1 && report_.frames_apart <= kMaxApart) {
    const Residual right_late = measure(storage_.before[0], storage_.now[1], 0);
    const Residual right_early = measure(storage_.now[0], storage_.before[1], 0);
    if (report_.frames_apart == 1) {
      vote(same, right_late, right_early);
    } else {
      vote_by_motion(same, right_late, right_early, report_.frames_apart);
    }
  }
  return true;
}

SyncMonitor::Residual SyncMonitor::look(const RectifiedPair& pair) noexcept {
  prepare_patches(pair.left, storage_.now[0]);
  prepare_patches(pair.right, storage_.now[1]);
  const Residual same = measure(storage_.now[0], storage_.now[1], -config_.max_disparity_px);
  ++report_.measurements;
  report_.matches = same.matches;
  report_.searched = same.searched;
  report_.in_front = same.in_front;
  report_.beyond_infinity = same.beyond_infinity;
  report_.disparity_px = same.disparity_px;
  report_.residual_px = same.median_px;
  report_.signed_residual_px = same.signed_px;
  report_.latest = SyncVerdict::kUnknown;
  return same;
}

SyncMonitor::Residual SyncMonitor::measure(GrayView left, GrayView right, int least_disparity_px) const noexcept {
  const PatchMatches matches = match_patches(left, right, {least_disparity_px, config_.max_disparity_px});
  Residual residual{.matches = static_cast<int>(matches.count), .searched = static_cast<int>(matches.searched)};
  if (matches.count == 0) {
    return residual;
  }
  std::array<double, PatchMatches{}.found.size()> disparities{};
  std::array<double, PatchMatches{}.found.size()> rows{};
  for (std::size_t i = 0; i < matches.count; ++i) {
    rows[i] = matches.found[i].row_px;
    disparities[i] = matches.found[i].disparity_px;
    residual.beyond_infinity += matches.found[i].disparity_px < -kSurelyShifted_px ? 1 : 0;
    residual.in_front += matches.found[i].disparity_px > kSurelyShifted_px ? 1 : 0;
  }
  residual.disparity_px = median(std::span(disparities).first(matches.count));
  const std::span<double> found(rows.data(), matches.count);
  residual.signed_px = median(found);
  std::transform(found.begin(), found.end(), found.begin(), [](double shift) { return std::abs(shift); });
  residual.median_px = median(found);
  return residual;
}

void SyncMonitor::vote(const Residual& same, const Residual& right_late, const Residual& right_early) noexcept {
  if (std::max({same.matches, right_late.matches, right_early.matches}) < kMinMatches) {
    return;
  }
  // Images without matches get the largest observable residual.
  const auto effective_px = [](const Residual& residual) {
    return residual.matches >= kMinMatches ? residual.median_px : kMaxRowShift_px;
  };
  const double same_px = effective_px(same);
  const double late_px = effective_px(right_late);
  const double early_px = effective_px(right_early);
  const double other_px = std::min(late_px, early_px);
  if (same_px > kMinAsyncResidual_px && other_px < kMuchBetter * same_px) {
    cast(late_px < early_px ? SyncVerdict::kRightLate : SyncVerdict::kRightEarly);
  } else if (other_px > kMinAsyncResidual_px && same_px < kMuchBetter * other_px) {
    cast(SyncVerdict::kInStep);
  }
}

// The true partner of a late image is missing: frames in between were skipped. If rows move by v per frame, synchronous
// views differ by 0 in one frame and by n v over n frames, either way; with the right view one frame late they differ
// by v in one frame, and by (n - 1) v and (n + 1) v over n frames.
void SyncMonitor::vote_by_motion(const Residual& same, const Residual& right_late, const Residual& right_early,
                                 int frames_apart) noexcept {
  if (std::min({same.matches, right_late.matches, right_early.matches}) < kMinMatches) {
    return;
  }
  const double motion_px = (right_late.median_px + right_early.median_px) / (2.0 * frames_apart);
  if (motion_px < kMinMotion_px) {
    return;
  }
  // In frames; for uniform motion both are 0 in step and 1 out of step.
  const double late = (right_early.median_px - right_late.median_px) / (2.0 * motion_px);
  const double off = same.median_px / motion_px;
  if (std::abs(late) > kOutOfStepFrames && off > kOutOfStepFrames) {
    cast(late > 0.0 ? SyncVerdict::kRightLate : SyncVerdict::kRightEarly);
  } else if (std::abs(late) < 1.0 - kOutOfStepFrames && off < 1.0 - kOutOfStepFrames) {
    cast(SyncVerdict::kInStep);
  }
}

void SyncMonitor::restart() noexcept {
  pairs_ = 0;
  vote_count_ = 0;
  report_.verdict = SyncVerdict::kUnknown;
  report_.agreeing = 0;
}

void SyncMonitor::cast(SyncVerdict verdict_now) noexcept {
  report_.latest = verdict_now;
  votes_[vote_count_++ % kVotes] = verdict_now;
  constexpr auto kMinVotes = static_cast<std::ptrdiff_t>(3);
  const std::size_t count = std::min(vote_count_, kVotes);
  report_.verdict = SyncVerdict::kUnknown;
  report_.agreeing = 0;
  for (const SyncVerdict verdict : {SyncVerdict::kInStep, SyncVerdict::kRightLate, SyncVerdict::kRightEarly}) {
    const auto votes = std::count(votes_.begin(), votes_.begin() + static_cast<std::ptrdiff_t>(count), verdict);
    if (votes >= kMinVotes && 4 * votes >= 3 * static_cast<std::ptrdiff_t>(count)) {
      report_.verdict = verdict;
      report_.agreeing = static_cast<int>(votes);
    }
  }
}

}  // namespace kinetrace::hal

#include "segmentation/network_thread.hpp"

#include <algorithm>
#include <array>
#include <condition_variable>
#include <fstream>
#include <mutex>
#include <optional>
#include <sys/resource.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/quantiles.hpp"
#include "kinetrace/neural/instance_network.hpp"

namespace kinetrace::app {
namespace {

using Clock = std::chrono::steady_clock;
using neural::InstanceNetwork;

constexpr std::size_t kTimes = 256;

std::size_t resident_bytes() {
  std::size_t total_pages = 0;
  std::size_t resident_pages = 0;
  std::ifstream("/proc/self/statm") >> total_pages >> resident_pages;
  return resident_pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

// Frames have the processor first: a thread that is nicer by this gets a sixtieth of what another one gets, and the
// rest of the time alone. It holds for the calling thread and for those it starts. A refusal by the system is ignored.
constexpr int kNetworkNiceness = 19;

void give_way_to_frames() {
  static_cast<void>(::setpriority(PRIO_PROCESS, 0, ::getpriority(PRIO_PROCESS, 0) + kNetworkNiceness));
}

/// Masks of one image, kept beyond the network's next answer.
struct MaskStore {
  FixedVector<RunLengthMask> masks;
  FixedVector<std::uint16_t> runs;

  MaskStore() = default;
  explicit MaskStore(Arena& arena)
      : masks(arena, InstanceNetwork::kMaxInstances), runs(arena, InstanceNetwork::kMaxRuns) {}

  void keep(std::span<const RunLengthMask> found) noexcept {
    masks.clear();
    runs.clear();
    for (RunLengthMask mask : found) {
      const std::size_t first = runs.size();
      for (const std::uint16_t run : mask.runs) {
        static_cast<void>(runs.push_back(run));
      }
      mask.runs = runs.span().subspan(first);
      static_cast<void>(masks.push_back(mask));
    }
  }
};

struct Answer {
  MaskStore left;
  MaskStore right;
  MaskSet set;
};

}  // namespace

struct NetworkThread::Shared {
  enum class State : std::uint8_t { kIdle, kAsked, kAnswered, kFailed };

  NetworkThreadConfig config;
  neural::NetworkOptions options;
  std::optional<Arena> arena;
  std::unique_ptr<InstanceNetwork> network;

  // Written by the offering thread while idle, read by the network's thread while asked.
  MutableGrayView left;
  MutableGrayView right;
  PixelBox region_px;  ///< Region of the left image, which is then the only one segmented; empty: all images in full.
  std::array<Answer, 2> answers;
  std::size_t asked_answer = 0;  ///< Index of the answer that the thread fills; the pipeline reads the other one.

  mutable std::mutex mutex;
  std::condition_variable changed;
  // All guarded by the mutex.
  State state = State::kIdle;
  bool ends = false;
  std::optional<Status> started;
  NetworkThreadCounters counters;
  std::vector<double> times_ms;
  std::string first_error;

  void carve(Arena& from) {
    left = take_image<std::uint8_t>(from, options.max_width_px, options.max_height_px);
    if (config.right || config.model.input.disparity) {
      right = take_image<std::uint8_t>(from, options.max_width_px, options.max_height_px);
    }
    for (Answer& answer : answers) {
      answer.left = MaskStore(from);
      if (config.right) {
        answer.right = MaskStore(from);
      }
    }
  }

  Status start() {
    arena.emplace(measure_bytes([this](Arena& measuring) { carve(measuring); }) +
                  InstanceNetwork::required_bytes(config.model, options) + Arena::kAlignment);
    carve(*arena);
    times_ms.reserve(kTimes);
    auto made = InstanceNetwork::create(config.model, options, *arena);
    if (!made) {
      return Unexpected(made.error());
    }
    network = std::move(*made);
    // Segments a whole frame once, so that all its allocations happen now.
    return segment(answers[1]);
  }

  Status segment(Answer& answer) {
    const PixelBox whole_px{0, 0, left.width, left.height};
    const auto look = [&](const neural::StereoPicture& pictures, const PixelBox& part_px, MaskStore& store) -> Status {
      const auto found = network->segment(pictures, part_px);
      if (!found) {
        return Unexpected(found.error());
      }
      store.keep(*found);
      return {};
    };
    const GrayView left_image = left;
    const GrayView right_image = right;
    const neural::StereoPicture of_left{left_image, right_image, View::kLeft};
    if (Status seen = look(of_left, region_px.empty() ? whole_px : region_px, answer.left); !seen) {
      return seen;
    }
    answer.right.keep({});
    if (config.right && region_px.empty()) {
      if (Status seen = look({right_image, left_image, View::kRight}, whole_px, answer.right); !seen) {
        return seen;
      }
    }
    answer.set = {answer.left.masks.span(), answer.right.masks.span()};
    return {};
  }

  /// With the mutex held.
  void count(const Status& seen, Clock::duration took) {
    const double took_ms = std::chrono::duration<double, std::milli>(took).count();
    if (times_ms.size() < kTimes) {
      times_ms.push_back(took_ms);
    } else {
      times_ms[counters.frames % kTimes] = took_ms;
    }
    ++counters.frames;
    counters.longest_ms = std::max(counters.longest_ms, took_ms);
    if (!seen) {
      ++counters.failed;
      first_error = first_error.empty() ? seen.error().message : first_error;
    }
  }
};

NetworkThread::NetworkThread(std::shared_ptr<Shared> shared) : shared_(std::move(shared)) {}

void NetworkThread::run(Shared& shared) {
  give_way_to_frames();
  const Status started = shared.start();
  std::unique_lock lock(shared.mutex);
  shared.started = started;
  shared.changed.notify_all();
  while (started) {
    shared.changed.wait(lock, [&] { return shared.ends || shared.state == Shared::State::kAsked; });
    if (shared.ends) {
      shared.state = Shared::State::kIdle;  // A request that was not begun ends the wait for it.
      shared.changed.notify_all();
      return;
    }
    Answer& answer = shared.answers[shared.asked_answer];
    lock.unlock();
    const Clock::time_point begun = Clock::now();
    const Status seen = shared.segment(answer);
    lock.lock();
    shared.count(seen, Clock::now() - begun);
    shared.state = seen ? Shared::State::kAnswered : Shared::State::kFailed;
    shared.changed.notify_all();
  }
}

Result<std::unique_ptr<NetworkThread>> NetworkThread::create(const NetworkThreadConfig& config,
                                                             const StereoGeometry& geometry) {
  const std::size_t before_bytes = resident_bytes();
  auto shared = std::make_shared<Shared>();
  shared->config = config;
  shared->options = {.runtime = config.runtime,
                     .threads = config.threads,
                     .max_width_px = geometry.width_px,
                     .max_height_px = geometry.height_px};
  std::unique_ptr<NetworkThread> made(new NetworkThread(shared));
  made->thread_ = std::thread([shared] { run(*shared); });
  std::unique_lock lock(shared->mutex);
  shared->changed.wait(lock, [&] { return shared->started.has_value(); });
  if (!*shared->started) {
    return Unexpected(shared->started->error());
  }
  made->bytes_ = resident_bytes() - std::min(before_bytes, resident_bytes());
  return made;
}

NetworkThread::~NetworkThread() {
  {
    std::unique_lock lock(shared_->mutex);
    shared_->ends = true;
    shared_->changed.notify_all();
    hangs_ = hangs_ || !shared_->changed.wait_for(lock, shared_->config.timeout,
                                                  [this] { return shared_->state != Shared::State::kAsked; });
  }
  if (hangs_) {
    thread_.detach();
  } else {
    thread_.join();
  }
}

void NetworkThread::offer(const RectifiedPair& pair, const PixelBox& region_px) noexcept {
  copy_image<std::uint8_t>(pair.left, shared_->left);
  if (!shared_->right.empty()) {
    copy_image<std::uint8_t>(pair.right, shared_->right);
  }
  shared_->region_px = region_px;
  const std::lock_guard lock(shared_->mutex);
  shared_->state = Shared::State::kAsked;
  shared_->changed.notify_all();
}

DelayedMasks NetworkThread::take() noexcept {
  std::unique_lock lock(shared_->mutex);
  const auto is_done = [this] { return shared_->state != Shared::State::kAsked; };
  if (shared_->config.waits && !hangs_) {
    hangs_ = !shared_->changed.wait_for(lock, shared_->config.timeout, is_done);
  }
  if (!is_done()) {
    return {};
  }
  hangs_ = false;
  const bool has_failed = shared_->state == Shared::State::kFailed;
  shared_->state = Shared::State::kIdle;
  const MaskSet& set = shared_->answers[shared_->asked_answer].set;
  shared_->asked_answer = 1 - shared_->asked_answer;
  return {true, has_failed ? nullptr : &set};
}

NetworkThreadCounters NetworkThread::counters() const {
  const std::lock_guard lock(shared_->mutex);
  NetworkThreadCounters counters = shared_->counters;
  if (!shared_->times_ms.empty()) {
    counters.median_ms = median(std::vector(shared_->times_ms));
  }
  return counters;
}

std::string NetworkThread::first_error() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->first_error;
}

}  // namespace kinetrace::app

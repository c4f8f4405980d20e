#include "capture/stereo_pairer.hpp"

#include <utility>

namespace kinetrace::hal {
namespace {

// Pause for a device that reports itself ready but has no image.
constexpr std::int64_t kPollBackoff_ns = 1'000'000;

View view_of(std::size_t camera) {
  return camera == 0 ? View::kLeft : View::kRight;
}

}  // namespace

StereoPairer::StereoPairer(std::span<CaptureStream> streams, CaptureEnvironment& environment, const SyncConfig& config,
                           int buffers, CameraCounters& counters)
    : streams_(streams),
      environment_(&environment),
      config_(config),
      buffers_(buffers),
      counters_(&counters),
      synchronizer_(config) {}

void StereoPairer::begin() noexcept {
  static_cast<void>(forget_restarted());  // First starts are no restarts.
  missed_.restart();
}

std::array<WaitHandle, 2> StereoPairer::wait_for_images(std::int64_t until_ns) {
  std::array<WaitHandle, 2> handles{};
  for (std::size_t camera = 0; camera < streams_.size(); ++camera) {
    handles[camera].fd = streams_[camera].wait_fd();
  }
  environment_->wait(std::span(handles).first(streams_.size()), until_ns);
  return handles;
}

void StereoPairer::wait(std::int64_t now_ns, std::int64_t until_ns) {
  if (falsely_ready_) {  // Waiting for that device would return at once.
    environment_->wait({}, now_ns + kPollBackoff_ns);
  } else {
    static_cast<void>(wait_for_images(until_ns));
  }
}

// Alternates between the devices.
Status StereoPairer::gather() {
  falsely_ready_ = false;
  bool any_ready = true;
  for (int round = 0; any_ready && round < buffers_; ++round) {
    const std::array<WaitHandle, 2> handles = wait_for_images(0);
    any_ready = false;
    for (std::size_t camera = 0; camera < streams_.size(); ++camera) {
      if (!handles[camera].ready) {
        streams_[camera].note_empty();
        continue;
      }
      any_ready = true;
      const Result<bool> taken = take_image(camera);
      if (!taken) {
        return Unexpected(taken.error());
      }
      falsely_ready_ = falsely_ready_ || !*taken;
    }
  }
  return {};
}

// Whether the device had a usable image.
Result<bool> StereoPairer::take_image(std::size_t camera) {
  const Result<std::optional<SyncFrame>> frame = streams_[camera].take(*counters_);
  counters_->stream_restarts += forget_restarted();
  missed_.see(view_of(camera), streams_[camera].image_number());
  if (!frame) {
    return Unexpected(frame.error());
  }
  if (!*frame) {
    return false;
  }
  if (side_by_side()) {
    offer({**frame, **frame});
    return true;
  }
  synchronizer_.add(view_of(camera), **frame);
  while (const std::optional<SyncPair> pair = synchronizer_.next_pair()) {
    offer(*pair);
  }
  count_drops();
  return true;
}

// A restarted stream owns all its buffers again: none may be used or released any more.
std::uint64_t StereoPairer::forget_restarted() noexcept {
  std::uint64_t restarts = 0;
  for (std::size_t camera = 0; camera < streams_.size(); ++camera) {
    if (generations_[camera] == streams_[camera].generation()) {
      continue;
    }
    generations_[camera] = streams_[camera].generation();
    ++restarts;
    synchronizer_.forget(view_of(camera));
    counters_->skipped_missing_side += newest_ ? 1 : 0;
    if (newest_ && !side_by_side()) {
      const bool left_is_gone = camera == 0;
      streams_[left_is_gone ? 1 : 0].release(left_is_gone ? newest_->right.slot : newest_->left.slot);
    }
    newest_.reset();
  }
  return restarts;
}

void StereoPairer::offer(const SyncPair& pair) noexcept {
  counters_->skipped_outdated += newest_ ? 1 : 0;
  release(newest_);
  newest_ = pair;
}

void StereoPairer::count_drops() noexcept {
  while (const std::optional<SyncDrop> drop = synchronizer_.next_drop()) {
    const bool is_stale = drop->reason == SyncDrop::Reason::kStale;
    ++(is_stale ? counters_->skipped_repeated : counters_->skipped_missing_side);
    streams_[static_cast<std::size_t>(drop->view)].release(drop->frame.slot);
  }
  counters_->pairing_slips = synchronizer_.counters().slips;
}

std::optional<SyncPair> StereoPairer::take() {
  release_taken();
  taken_ = std::exchange(newest_, std::nullopt);
  return taken_;
}

void StereoPairer::release(std::optional<SyncPair>& pair) noexcept {
  if (!pair) {
    return;
  }
  streams_[0].release(pair->left.slot);
  if (!side_by_side()) {
    streams_[1].release(pair->right.slot);
  }
  pair.reset();
}

void StereoPairer::release_taken() noexcept {
  release(taken_);
}

void StereoPairer::release_all() noexcept {
  release(taken_);
  release(newest_);
}

std::optional<StereoViews> StereoPairer::views(const SyncPair& pair) {
  Result<GrayView> left = streams_[0].luminance(pair.left.slot);
  Result<GrayView> right = side_by_side() ? left : streams_[1].luminance(pair.right.slot);
  if (!left || !right) {
    return std::nullopt;
  }
  if (side_by_side()) {
    left->width /= 2;
    right->width = left->width;
    right->data += left->width;
  }
  return StereoViews{*left, *right};
}

void StereoPairer::count_gaps(const SyncPair& pair) noexcept {
  counters_->gaps += missed_.deliver(pair.left.sequence, pair.right.sequence);
}

bool StereoPairer::move(int frames) noexcept {
  if (side_by_side()) {
    return false;
  }
  synchronizer_.move(frames);
  ++counters_->pairing_moves;
  return true;
}

}  // namespace kinetrace::hal

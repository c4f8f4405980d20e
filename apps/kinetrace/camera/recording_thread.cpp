#include "camera/recording_thread.hpp"

#include <algorithm>
#include <cmath>

#include "kinetrace/core/files.hpp"

namespace kinetrace::app {

namespace {

Unexpected<Failure> not_begun(const Error& error) {
  const bool is_folder = error.code == ErrorCode::kIo || error.code == ErrorCode::kInvalidArgument;
  return is_folder ? Unexpected(Failure{ExitCode::kCannotCreate, error.message}) : failure(error);
}

}  // namespace

hal::RawRecorderConfig raw_recorder_config(const RawOutputOptions& options, const hal::RigCalibration& calibration,
                                           double rate_hz) {
  constexpr unsigned kMib = 20;
  return {.directory = options.out,
          .format = options.container ? hal::RawFormat::kContainer : hal::RawFormat::kKittiRaw,
          .calibration = calibration,
          .rate_hz = rate_hz,
          .segment_bytes = static_cast<std::uint64_t>(options.segment_mib) << kMib,
          .keep_free_bytes = static_cast<std::uint64_t>(options.keep_free_mib) << kMib};
}

void RecordingThread::carve(const hal::RawRecorderConfig& config, Arena& arena, Slots& slots) {
  for (Slot& slot : slots) {
    for (MutableGrayView& image : slot.images) {
      image = take_image<std::uint8_t>(arena, config.calibration.raw_width_px(), config.calibration.raw_height_px());
    }
  }
}

std::size_t RecordingThread::required_bytes(const hal::RawRecorderConfig& config) {
  const std::size_t queue = measure_bytes([&config](Arena& arena) {
    Slots slots;
    carve(config, arena, slots);
  });
  return queue + hal::RawRecorder::required_bytes(config) + Arena::kAlignment;
}

Outcome<void> RecordingThread::check(const hal::RawRecorderConfig& config, const std::filesystem::path& recording) {
  if (!recording.empty() && is_inside(config.directory, recording)) {
    return Unexpected(Failure{ExitCode::kCannotCreate, config.directory.string() + ": lies in the recording " +
                                                           recording.string() + "; name another folder"});
  }
  const Status can = hal::RawRecorder::check(config);
  return can ? Outcome<void>{} : not_begun(can.error());
}

Outcome<std::unique_ptr<RecordingThread>> RecordingThread::create(const hal::RawRecorderConfig& config, Arena& arena) {
  Slots slots;
  carve(config, arena, slots);
  if (arena.exhausted()) {
    return failure(
        {ErrorCode::kCapacity, "the arena does not hold the queue of raw images; enlarge the memory budget"});
  }
  auto recorder = hal::RawRecorder::create(config, arena);
  if (!recorder) {
    return not_begun(recorder.error());
  }
  return std::unique_ptr<RecordingThread>(new RecordingThread(std::move(*recorder), config.rate_hz, slots));
}

RecordingThread::RecordingThread(std::unique_ptr<hal::RawRecorder> recorder, double rate_hz, const Slots& slots)
    : recorder_(std::move(recorder)),
      // About once a second: bounds the loss at a power failure.
      frames_between_syncs_(std::max<std::int64_t>(1, std::llround(rate_hz))),
      slots_(slots),
      thread_([this] { run(); }) {}

bool RecordingThread::has_room_for(const StereoFrame& frame) const noexcept {
  const MutableGrayView& room = slots_[0].images[0];
  return frame.left.width == room.width && frame.left.height == room.height && frame.right.width == room.width &&
         frame.right.height == room.height;
}

void RecordingThread::offer(const StereoFrame& frame) noexcept {
  std::size_t free = 0;
  {
    const std::lock_guard lock(mutex_);
    if (failure_ || ends_) {
      return;
    }
    if (count_ == kSlots || !has_room_for(frame)) {
      ++dropped_;
      return;
    }
    free = (first_ + count_) % kSlots;
  }
  Slot& slot = slots_[free];
  slot.frame = frame;
  slot.frame.name = {};
  copy_image(frame.left, slot.images[0]);
  copy_image(frame.right, slot.images[1]);
  slot.frame.left = slot.images[0];
  slot.frame.right = slot.images[1];
  {
    const std::lock_guard lock(mutex_);
    ++count_;
  }
  changed_.notify_all();
}

void RecordingThread::wait_for_room() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return count_ < kSlots || failure_ || ends_; });
}

void RecordingThread::fail_with(const Error& error) {
  {
    const std::lock_guard lock(mutex_);
    failure_ = error;
  }
  changed_.notify_all();
}

void RecordingThread::run() {
  for (;;) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return count_ > 0 || ends_; });
    if (count_ == 0) {
      break;
    }
    const Slot& slot = slots_[first_];
    lock.unlock();
    Status written = recorder_->write(slot.frame);
    if (written && recorder_->frames() % frames_between_syncs_ == 0) {
      written = recorder_->sync();
    }
    if (!written) {
      fail_with(written.error());
      return;
    }
    written_ = recorder_->frames();
    lock.lock();
    first_ = (first_ + 1) % kSlots;
    --count_;
    lock.unlock();
    changed_.notify_all();
  }
  if (const Status synced = recorder_->sync(); !synced) {
    fail_with(synced.error());
  }
}

void RecordingThread::finish() noexcept {
  if (!thread_.joinable()) {
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

std::optional<Error> RecordingThread::stopped_by() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

}  // namespace kinetrace::app

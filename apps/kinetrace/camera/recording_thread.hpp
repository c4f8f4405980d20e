// Records raw pairs to disk without blocking the camera.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "cli/failure.hpp"
#include "cli/shared_options.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/hal/raw_recorder.hpp"

namespace kinetrace::app {

[[nodiscard]] hal::RawRecorderConfig raw_recorder_config(const RawOutputOptions& options,
                                                         const hal::RigCalibration& calibration, double rate_hz);

/// A RawRecorder in a thread of its own, behind a queue of `kSlots` pairs. While the queue is full, pairs are dropped
/// and counted. A failure of the recorder ends recording alone. Memory from the arena: the queue.
class RecordingThread {
 public:
  static constexpr std::size_t kSlots = 8;

  [[nodiscard]] static std::size_t required_bytes(const hal::RawRecorderConfig& config);
  /// See RawRecorder::check; nor may it lie in `recording`, the folder of the recording that is played: its images
  /// would be a part of that one. Empty: none. Failures: as of `create`.
  [[nodiscard]] static Outcome<void> check(const hal::RawRecorderConfig& config,
                                           const std::filesystem::path& recording);
  /// Failures: kCannotCreate for the folder; else as errors of RawRecorder::create.
  [[nodiscard]] static Outcome<std::unique_ptr<RecordingThread>> create(const hal::RawRecorderConfig& config,
                                                                        Arena& arena);
  RecordingThread(const RecordingThread&) = delete;
  RecordingThread& operator=(const RecordingThread&) = delete;
  ~RecordingThread() { finish(); }

  /// Copies the pair; never waits for the disk. Pairs of another size than the rig's are dropped.
  void offer(const StereoFrame& frame) noexcept;
  /// Waits until the queue has room or recording has ended: for recordings, which can wait.
  void wait_for_room();
  /// Writes the queued pairs and ends the thread.
  void finish() noexcept;

  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }
  [[nodiscard]] std::int64_t written() const noexcept { return written_; }
  /// Why recording ended before finish(); none if it did not.
  [[nodiscard]] std::optional<Error> stopped_by() const;

 private:
  struct Slot {
    StereoFrame frame;
    std::array<MutableGrayView, 2> images;
  };
  using Slots = std::array<Slot, kSlots>;
  RecordingThread(std::unique_ptr<hal::RawRecorder> recorder, double rate_hz, const Slots& slots);
  static void carve(const hal::RawRecorderConfig& config, Arena& arena, Slots& slots);
  [[nodiscard]] bool has_room_for(const StereoFrame& frame) const noexcept;
  void run();
  void fail_with(const Error& error);

  std::unique_ptr<hal::RawRecorder> recorder_;
  std::int64_t frames_between_syncs_;
  Slots slots_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // Guarded by the mutex; slots [first_, first_ + count_) belong to the thread, the others to offer().
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  bool ends_ = false;
  std::optional<Error> failure_;
  std::atomic<std::int64_t> written_ = 0;
  std::uint64_t dropped_ = 0;
  std::thread thread_;
};

}  // namespace kinetrace::app

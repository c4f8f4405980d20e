// Processing in a thread of its own, so that capture never blocks.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <latch>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/latest_value.hpp"
#include "kinetrace/core/result.hpp"
#include "live/event_fd.hpp"

namespace kinetrace::app {

/// Passes rectified pairs from the capture thread to the processing thread; the newest wins. Memory from the arena:
/// three pairs of images.
class PipelineThread {
 public:
  /// Both are called from the processing thread. `exposed_ns`: value given to offer().
  using Process = std::function<Status(const RectifiedPair& pair, std::int64_t exposed_ns)>;
  using Idle = std::function<void()>;

  [[nodiscard]] static std::size_t required_bytes(const StereoGeometry& geometry);
  /// `idle` is called periodically while no pair arrives. Errors: kCapacity; kIo (limit of open files).
  [[nodiscard]] static Result<std::unique_ptr<PipelineThread>> create(const StereoGeometry& geometry, Process process,
                                                                      Idle idle, Arena& arena);
  PipelineThread(const PipelineThread&) = delete;
  PipelineThread& operator=(const PipelineThread&) = delete;
  ~PipelineThread() { static_cast<void>(finish()); }

  /// Copies the pair and returns at once. True if it replaced a waiting pair. Errors: those of `process`, after which
  /// processing stops.
  [[nodiscard]] Result<bool> offer(const RectifiedPair& pair, std::int64_t exposed_ns);
  /// Processes the waiting pair and ends the thread. Errors: those of `process`.
  [[nodiscard]] Status finish() noexcept;

 private:
  struct Slot {
    RectifiedPair pair;
    std::string name;  ///< Storage of pair.name; allocated once.
    std::int64_t exposed_ns = 0;
    MutableGrayView left;
    MutableGrayView right;
  };
  PipelineThread(const StereoGeometry& geometry, Process process, Idle idle, Arena& arena);
  [[nodiscard]] static Slot carve(const StereoGeometry& geometry, Arena& arena);
  void run();
  /// False if no pair waits.
  bool process_newest();
  [[nodiscard]] Status failure() const;

  Process process_;
  Idle idle_;
  LatestValue<Slot> slots_;
  EventFd wake_event_;
  mutable std::mutex mutex_;
  std::optional<Error> failure_;  ///< Guarded by the mutex.
  std::latch has_begun_{1};
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace kinetrace::app

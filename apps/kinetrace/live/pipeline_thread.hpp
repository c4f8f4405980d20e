// Processing in a thread of its own, so that a camera is never kept waiting.
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

/// Hands rectified pairs from the thread that captures to the one that processes; the newest wins. Memory from the
/// arena: three pairs of images.
class PipelineThread {
 public:
  /// Both are called from the thread. `exposed_ns` as given to offer().
  using Process = std::function<Status(const RectifiedPair& pair, std::int64_t exposed_ns)>;
  using Idle = std::function<void()>;

  [[nodiscard]] static std::size_t required_bytes(const StereoGeometry& geometry);
  /// `idle` is called now and then while nothing comes. Errors: kCapacity; kIo if the process may have no more files.
  [[nodiscard]] static Result<std::unique_ptr<PipelineThread>> create(const StereoGeometry& geometry, Process process,
                                                                      Idle idle, Arena& arena);
  PipelineThread(const PipelineThread&) = delete;
  PipelineThread& operator=(const PipelineThread&) = delete;
  ~PipelineThread() { static_cast<void>(finish()); }

  /// Copies the pair and returns at once. True if one that waited was left out for it. Errors: those of `process`,
  /// after which nothing is processed any more.
  [[nodiscard]] Result<bool> offer(const RectifiedPair& pair, std::int64_t exposed_ns);
  /// Processes what waits and ends. Errors: those of `process`.
  [[nodiscard]] Status finish() noexcept;

 private:
  struct Slot {
    RectifiedPair pair;
    std::string name;  ///< Of which pair.name is a view; its memory is taken once.
    std::int64_t exposed_ns = 0;
    MutableGrayView left;
    MutableGrayView right;
  };
  PipelineThread(const StereoGeometry& geometry, Process process, Idle idle, Arena& arena);
  [[nodiscard]] static Slot carve(const StereoGeometry& geometry, Arena& arena);
  void run();
  /// False when there is nothing.
  bool process_newest();
  [[nodiscard]] Status failure() const;

  Process process_;
  Idle idle_;
  LatestValue<Slot> slots_;
  EventFd news_;
  mutable std::mutex mutex_;
  std::optional<Error> failure_;  ///< Guarded by the mutex.
  std::latch has_begun_{1};
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace kinetrace::app

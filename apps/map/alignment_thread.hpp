// Aligns on a thread of its own; receiving and publishing never wait for it.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "kinetrace/core/result.hpp"
#include "live_alignment.hpp"

namespace kinetrace::map {

class AlignmentThread {
 public:
  /// The thread calls `on_done` when a result is ready.
  explicit AlignmentThread(std::function<void()> on_done);
  AlignmentThread(const AlignmentThread&) = delete;
  AlignmentThread& operator=(const AlignmentThread&) = delete;
  ~AlignmentThread();

  /// The task, to be filled in and then begun; null while one is running or not yet collected.
  [[nodiscard]] AlignmentTask* idle_task() noexcept;
  void begin();
  /// The result of the task, once.
  [[nodiscard]] std::optional<Result<geo::Alignment>> collect();
  [[nodiscard]] const AlignmentTask& task() const noexcept { return task_; }
  /// Duration of the last alignment.
  [[nodiscard]] std::int64_t took_ns() const noexcept { return took_ns_; }

 private:
  enum class State { kIdle, kAtWork, kDone };
  void work();

  std::function<void()> on_done_;
  std::mutex mutex_;
  std::condition_variable changed_;
  State state_ = State::kIdle;
  bool ends_ = false;
  AlignmentTask task_;  ///< Its owner depends on the state.
  std::optional<Result<geo::Alignment>> done_;
  std::int64_t took_ns_ = 0;
  std::thread thread_;
};

}  // namespace kinetrace::map

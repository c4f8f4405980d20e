// Aligns beside what is received and published, which never waits for it.
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
  /// `on_done` is called by the thread when there is something to collect.
  explicit AlignmentThread(std::function<void()> on_done);
  AlignmentThread(const AlignmentThread&) = delete;
  AlignmentThread& operator=(const AlignmentThread&) = delete;
  ~AlignmentThread();

  /// The task, to be filled in and then begun; null while one is at work or waits to be collected.
  [[nodiscard]] AlignmentTask* idle_task() noexcept;
  void begin();
  /// What became of it, once.
  [[nodiscard]] std::optional<Result<geo::Alignment>> collect();
  [[nodiscard]] const AlignmentTask& task() const noexcept { return task_; }
  /// How long the last one took.
  [[nodiscard]] std::int64_t took_ns() const noexcept { return took_ns_; }

 private:
  enum class State { kIdle, kAtWork, kDone };
  void work();

  std::function<void()> on_done_;
  std::mutex mutex_;
  std::condition_variable changed_;
  State state_ = State::kIdle;
  bool ends_ = false;
  AlignmentTask task_;  ///< Of whom the state says.
  std::optional<Result<geo::Alignment>> done_;
  std::int64_t took_ns_ = 0;
  std::thread thread_;
};

}  // namespace kinetrace::map

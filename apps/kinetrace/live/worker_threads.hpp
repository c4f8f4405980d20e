// Threads that share the work of a frame.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include "kinetrace/core/workers.hpp"

namespace kinetrace::app {

/// Helpers of whoever calls run(). One that the system does not let run in time is not waited for: the caller does its
/// part, too.
class WorkerThreads final : public Workers {
 public:
  /// `count` with the caller; at 1 it works alone.
  explicit WorkerThreads(int count);
  ~WorkerThreads() override;

  void run(Job job) noexcept override;

 private:
  void serve(std::size_t worker) noexcept;
  /// Waits for the next round and joins it; false when there will be none.
  [[nodiscard]] bool join(std::uint32_t& last_round) noexcept;
  /// Waits until it is another.
  [[nodiscard]] std::uint32_t next_state(std::uint32_t state) noexcept;

  std::optional<Job> job_;
  /// The number of the round, whether helpers may join it, and how many are at it.
  std::atomic<std::uint32_t> state_{0};
  std::atomic<bool> ends_{false};
  std::vector<std::thread> threads_;
};

}  // namespace kinetrace::app

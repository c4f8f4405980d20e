// Worker threads within a frame.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <sched.h>
#include <thread>
#include <vector>

#include "kinetrace/core/workers.hpp"

namespace kinetrace::app {

/// Helper threads of the caller of run(). A helper that is not scheduled in time does not delay the round: the caller
/// takes over its part. Helpers run on other cores than the caller, of those that the process may use.
class WorkerThreads final : public Workers {
 public:
  /// `count` includes the caller; 1: no helpers.
  explicit WorkerThreads(int count);
  ~WorkerThreads() override;

  void run(Job job) noexcept override;

 private:
  /// Keeps helpers off the caller's core, if there is another one.
  void keep_apart() noexcept;
  void serve(std::size_t worker) noexcept;
  /// Waits for the next round and joins it; false at the end.
  [[nodiscard]] bool join(std::uint32_t& last_round) noexcept;
  /// Waits until the state differs from `state`.
  [[nodiscard]] std::uint32_t next_state(std::uint32_t state) noexcept;

  std::optional<Job> job_;
  /// Round number, whether helpers may join, and the number of helpers at work.
  std::atomic<std::uint32_t> state_{0};
  std::atomic<bool> ends_{false};
  cpu_set_t allowed_{};  ///< Cores of the process.
  int core_ = -1;        ///< The caller's, in the last round.
  std::vector<std::thread> threads_;
};

}  // namespace kinetrace::app

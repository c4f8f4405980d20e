#include "live/worker_threads.hpp"

#include <pthread.h>

namespace kinetrace::app {
namespace {

// Bit fields of the state, from the lowest bit.
constexpr std::uint32_t kAtWork = 0xFF;
constexpr std::uint32_t kOpen = 0x100;
constexpr unsigned kRoundShift = 9;

/// Yields before blocking: rounds of a frame follow each other within some 100 us, about the cost of a wake-up.
constexpr int kYields = 200;

constexpr std::uint32_t round_of(std::uint32_t state) noexcept {
  return state >> kRoundShift;
}

}  // namespace

WorkerThreads::WorkerThreads(int count) {
  static_cast<void>(::sched_getaffinity(0, sizeof(allowed_), &allowed_));  // fails: no cores, and no helper is bound
  for (int i = 1; i < count; ++i) {
    threads_.emplace_back([this, i] { serve(static_cast<std::size_t>(i)); });
  }
}

WorkerThreads::~WorkerThreads() {
  ends_ = true;
  state_ = (round_of(state_) + 1) << kRoundShift;
  state_.notify_all();
  for (std::thread& thread : threads_) {
    thread.join();
  }
}

void WorkerThreads::run(Job job) noexcept {
  if (threads_.empty()) {
    job(0);
    return;
  }
  keep_apart();
  job_ = job;
  // No helper is at work: the last round has ended. Release: a helper that joins sees the job.
  state_.store(((round_of(state_.load(std::memory_order_relaxed)) + 1) << kRoundShift) | kOpen,
               std::memory_order_release);
  state_.notify_all();
  job(0);
  // All parts have been started, so late helpers need not join.
  std::uint32_t state = state_.fetch_and(~kOpen, std::memory_order_acq_rel) & ~kOpen;
  while ((state & kAtWork) != 0) {
    state_.wait(state, std::memory_order_acquire);
    state = state_.load(std::memory_order_acquire);
  }
}

// The scheduler may queue a helper that it wakes behind the caller: the round would be over before the helper runs.
void WorkerThreads::keep_apart() noexcept {
  const int core = ::sched_getcpu();
  if (core < 0 || core == core_) {
    return;
  }
  core_ = core;
  cpu_set_t others = allowed_;
  CPU_CLR(core, &others);
  if (CPU_COUNT(&others) == 0) {
    return;
  }
  for (std::thread& thread : threads_) {
    static_cast<void>(::pthread_setaffinity_np(thread.native_handle(), sizeof(others), &others));
  }
}

std::uint32_t WorkerThreads::next_state(std::uint32_t state) noexcept {
  for (int i = 0; i < kYields; ++i) {
    const std::uint32_t now = state_.load(std::memory_order_acquire);
    if (now != state) {
      return now;
    }
    std::this_thread::yield();
  }
  state_.wait(state, std::memory_order_acquire);
  return state_.load(std::memory_order_acquire);
}

bool WorkerThreads::join(std::uint32_t& last_round) noexcept {
  std::uint32_t state = state_.load(std::memory_order_acquire);
  for (;;) {
    if (ends_) {
      return false;
    }
    if ((state & kOpen) == 0 || round_of(state) == last_round) {
      state = next_state(state);
    } else if (state_.compare_exchange_weak(state, state + 1, std::memory_order_acq_rel)) {
      last_round = round_of(state);
      return true;
    }
  }
}

void WorkerThreads::serve(std::size_t worker) noexcept {
  std::uint32_t last_round = 0;
  while (join(last_round)) {
    (*job_)(worker);
    state_.fetch_sub(1, std::memory_order_acq_rel);
    state_.notify_all();
  }
}

}  // namespace kinetrace::app

// Parallel work whose results do not depend on the number of threads.
#pragma once

#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace kinetrace::simulator {

/// Calls `work(i)` for i in [0, count), each once, in no particular order. Rethrows the first exception.
template <typename Work>
void for_each_index(int count, int threads, const Work& work) {
  std::atomic<int> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
  const auto run = [&] {
    try {
      for (int i = next++; i < count; i = next++) {
        work(i);
      }
    } catch (...) {
      const std::lock_guard lock(mutex);
      failure = std::current_exception();
      next = count;
    }
  };
  std::vector<std::jthread> helpers;
  for (int i = 1; i < threads && i < count; ++i) {
    helpers.emplace_back(run);
  }
  run();
  helpers.clear();
  if (failure) {
    std::rethrow_exception(failure);
  }
}

}  // namespace kinetrace::simulator

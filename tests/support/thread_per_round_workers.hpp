// Workers for tests: new threads for every round.
#pragma once

#include <cstddef>
#include <thread>
#include <vector>

#include "kinetrace/core/workers.hpp"

namespace kinetrace::test {

class ThreadPerRoundWorkers final : public Workers {
 public:
  explicit ThreadPerRoundWorkers(std::size_t count) : count_(count) {}
  void run(Job job) noexcept override {
    ++rounds;
    std::vector<std::thread> threads;
    for (std::size_t i = 1; i < count_; ++i) {
      threads.emplace_back([job, i] { job(i); });
    }
    job(0);
    for (std::thread& thread : threads) {
      thread.join();
    }
  }
  int rounds = 0;

 private:
  std::size_t count_;
};

}  // namespace kinetrace::test

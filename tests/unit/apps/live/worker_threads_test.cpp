#include "live/worker_threads.hpp"

#include <atomic>
#include <numeric>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::app {
namespace {

TEST(WorkerThreads, AllWorkIsDoneWhenRunReturns) {
  for (const int count : {1, 2, 4}) {
    WorkerThreads workers(count);
    std::vector<int> numbers(1000);
    for (int round = 1; round <= 2000; ++round) {
      in_pieces(&workers, numbers.size(), 50, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          ++numbers[i];
        }
      });
      ASSERT_EQ(std::accumulate(numbers.begin(), numbers.end(), 0), 1000 * round) << count;
    }
  }
}

TEST(WorkerThreads, OthersHelp) {
  WorkerThreads workers(2);
  std::atomic<int> at_work{0};
  std::atomic<bool> met{false};
  // Ends only when both work at the same time.
  in_pieces(&workers, 2, 1, [&](std::size_t /*begin*/, std::size_t /*end*/) {
    if (++at_work == 2) {
      met = true;
    }
    while (!met) {
      std::this_thread::yield();
    }
  });
  EXPECT_TRUE(met);
}

TEST(WorkerThreads, AJobHasTheNumbersOfItsWorkers) {
  WorkerThreads workers(3);
  std::atomic<int> callers{0};
  auto job = [&](std::size_t worker) {
    EXPECT_LT(worker, 3U);
    callers += worker == 0 ? 1 : 0;
  };
  for (int round = 0; round < 100; ++round) {
    workers.run(Job(job));
  }
  EXPECT_EQ(callers, 100);
}

TEST(WorkerThreads, EndWithoutHavingWorked) {
  for (int i = 0; i < 100; ++i) {
    const WorkerThreads workers(4);
  }
}

}  // namespace
}  // namespace kinetrace::app

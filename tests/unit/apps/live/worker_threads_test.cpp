#include "live/worker_threads.hpp"

#include <atomic>
#include <numeric>
#include <sched.h>
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

TEST(WorkerThreads, HelpersStayOffTheCallersCore) {
  cpu_set_t allowed;
  ASSERT_EQ(::sched_getaffinity(0, sizeof(allowed), &allowed), 0);
  if (CPU_COUNT(&allowed) < 2) {
    GTEST_SKIP() << "one core";
  }
  WorkerThreads workers(2);
  for (int core = 0; core < CPU_SETSIZE; ++core) {
    if (!CPU_ISSET(core, &allowed)) {
      continue;
    }
    cpu_set_t own;
    CPU_ZERO(&own);
    CPU_SET(core, &own);
    ASSERT_EQ(::sched_setaffinity(0, sizeof(own), &own), 0);
    std::atomic<bool> helped{false};
    auto job = [&](std::size_t worker) {
      if (worker == 0) {
        while (!helped) {
          std::this_thread::yield();
        }
        return;
      }
      cpu_set_t helpers;
      EXPECT_EQ(::sched_getaffinity(0, sizeof(helpers), &helpers), 0);
      EXPECT_FALSE(CPU_ISSET(core, &helpers));
      EXPECT_EQ(CPU_COUNT(&helpers), CPU_COUNT(&allowed) - 1);
      helped = true;
    };
    workers.run(Job(job));
  }
  EXPECT_EQ(::sched_setaffinity(0, sizeof(allowed), &allowed), 0);
}

TEST(WorkerThreads, EndWithoutHavingWorked) {
  for (int i = 0; i < 100; ++i) {
    const WorkerThreads workers(4);
  }
}

}  // namespace
}  // namespace kinetrace::app

#include "kinetrace/core/allocation_counter.hpp"

#include <atomic>
#include <cstdlib>
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace {
namespace {

/// Keeps the optimiser from removing an unused allocation.
void use(void* block) {
  asm volatile("" : : "g"(block) : "memory");
}

struct alignas(64) Line {
  char bytes[64];
};

TEST(AllocationCounter, SeesEveryWayToAskForMemory) {
  ASSERT_TRUE(allocation_counting_available());
  const auto counted = [](auto&& allocate) {
    const AllocationCounts before = allocation_counts();
    allocate();
    return allocation_counts().own - before.own;
  };
  EXPECT_EQ(counted([] { use(std::make_unique<int>(3).get()); }), 1U);
  EXPECT_EQ(counted([] { use(std::make_unique<Line>().get()); }), 1U);  // Aligned operator new.
  EXPECT_EQ(counted([] {
              void* p = std::malloc(10);
              use(p);
              p = std::realloc(p, 100'000);
              use(p);
              std::free(p);
            }),
            2U);
  EXPECT_EQ(counted([] {
              void* p = std::calloc(3, 5);
              use(p);
              std::free(p);
            }),
            1U);
  EXPECT_EQ(counted([] {
              void* p = nullptr;
              ASSERT_EQ(::posix_memalign(&p, 64, 256), 0);
              use(p);
              std::free(p);
            }),
            1U);
  EXPECT_EQ(counted([] {}), 0U);
}

TEST(AllocationCounter, AThreadThatALibraryStartsIsTheLibrarys) {
  const auto work = [] { use(std::make_unique<int>(1).get()); };
  const AllocationCounts before = allocation_counts();
  std::unique_ptr<std::thread> thread;
  {
    const ForeignCall foreign;
    thread = std::make_unique<std::thread>(work);
  }
  thread->join();
  EXPECT_EQ(allocation_counts().own, before.own);
  EXPECT_GE(allocation_counts().foreign, before.foreign + 3U) << "the thread's own, and what starting it takes";

  std::thread ours(work);
  ours.join();
  EXPECT_GE(allocation_counts().own, before.own + 1U);
}

TEST(AllocationCounter, CountsAForeignCallsAllocationsApart) {
  const AllocationCounts before = allocation_counts();
  {
    const ForeignCall outer;
    use(std::make_unique<int>(1).get());
    {
      const ForeignCall inner;
      use(std::make_unique<int>(2).get());
    }
    use(std::make_unique<int>(3).get());  // Still inside the outer call.
  }
  use(std::make_unique<int>(4).get());
  const AllocationCounts after = allocation_counts();
  EXPECT_EQ(after.foreign - before.foreign, 3U);
  EXPECT_EQ(after.own - before.own, 1U);
}

TEST(AllocationCounter, AForeignCallMarksItsOwnThreadOnly) {
  std::atomic<bool> inside{false};
  AllocationCounts before;
  AllocationCounts after;
  std::thread started_before([&] {
    while (!inside) {
      std::this_thread::yield();
    }
    before = allocation_counts();
    use(std::make_unique<int>(1).get());
    after = allocation_counts();
  });
  {
    const ForeignCall here;
    inside = true;
    started_before.join();
  }
  EXPECT_EQ(after.own - before.own, 1U);
  EXPECT_EQ(after.foreign, before.foreign);
}

}  // namespace
}  // namespace kinetrace

// Handing over and sending never allocate in our code. Not built with sanitizers, which replace malloc.
#include <gtest/gtest.h>

#include "kinetrace/core/allocation_counter.hpp"
#include "listener_process.hpp"
#include "publishing_load.hpp"

namespace kinetrace::test {
namespace {

TEST(PublishingAllocation, NothingOfOursIsAllocatedAfterStart) {
  ASSERT_TRUE(allocation_counting_available());
  PublishingLoad load;
  ListenerProcess listener(load.domain());
  ASSERT_TRUE(listener.wait_until_matched());
  const std::vector<std::unique_ptr<SampleResult>> samples = load.make_samples(90);
  const AllocationCounts before = allocation_counts();
  for (const auto& sample : samples) {
    load.offer(*sample);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const AllocationCounts after = allocation_counts();
  EXPECT_EQ(after.own - before.own, 0U);
  EXPECT_GT(after.foreign, before.foreign) << "the library's own threads and calls are counted apart";
}

}  // namespace
}  // namespace kinetrace::test

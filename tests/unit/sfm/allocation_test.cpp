// A body reconstruction allocates its memory at create and never again.
#include <vector>

#include <gtest/gtest.h>

#include "body_driver.hpp"
#include "kinetrace/core/allocation_counter.hpp"
#include "synthetic_world.hpp"

namespace kinetrace::sfm {
namespace {

TEST(BodyReconstructionAllocations, AreZeroAfterCreate) {
  ASSERT_TRUE(allocation_counting_available());
  kinetrace::test::SyntheticWorld world({.wrong_track_ratio = 0.1});
  test::BodyDriver driver{BodyConfig{}};
  std::vector<FeaturePrediction> predictions(1200);
  std::uint64_t allocations = 0;
  for (int i = 0; i < 30; ++i) {
    const FeatureFrame frame =
        i == 20 ? world.observe_nothing() : world.observe(kinetrace::test::driven(i < 15 ? 0.8 * i : 12.0));
    const std::uint64_t before = allocation_counts().own;
    driver.step(frame);
    if (i == 21) {
      driver.body().begin(driver.body().estimate().T_body_cam, BodyStatus::kPropagated);
      driver.finish(frame);
    }
    driver.body().predict_features(frame.features, 0, frame.timestamp_ns + 100'000'000, predictions);
    allocations += allocation_counts().own - before;
  }
  driver.body().end();
  EXPECT_EQ(allocations, 0U);
}

}  // namespace
}  // namespace kinetrace::sfm

#include <gtest/gtest.h>

#include "front_end_harness.hpp"
#include "kinetrace/core/allocation_counter.hpp"

namespace kinetrace::features {
namespace {

using testing::Scene;
using testing::StereoImage;
using testing::Texture;

TEST(FeatureAllocations, NoneAfterCreate) {
  ASSERT_TRUE(allocation_counting_available());
  const Texture texture(3);
  Scene scene;
  scene.left = [&](const Eigen::Vector2d& p) { return texture(p); };
  const StereoImage images = scene.render();
  const RectifiedPair pair = images.pair();
  Arena arena(FeatureFrontEnd::required_bytes({}, scene.width, scene.height));
  Result<FeatureFrontEnd> front_end = FeatureFrontEnd::create({}, scene.width, scene.height, arena);
  ASSERT_TRUE(front_end);

  const AllocationCounts before = allocation_counts();
  bool all_well = true;
  for (int frame = 0; frame < 3; ++frame) {
    all_well = all_well && front_end->begin_frame(pair) && front_end->track({}) && front_end->replenish({});
  }
  const AllocationCounts after = allocation_counts();
  EXPECT_TRUE(all_well);
  EXPECT_GT(front_end->counters().tracked, 100U);
  EXPECT_EQ(after.own, before.own);
  EXPECT_EQ(after.foreign, before.foreign);
}

}  // namespace
}  // namespace kinetrace::features

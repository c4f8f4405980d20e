// Durations of memory at two frame rates.
#include "kinetrace/segmentation/motion_memory.hpp"

#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::segmentation {
namespace {

class MotionMemoryTest : public ::testing::TestWithParam<int> {
 protected:
  [[nodiscard]] double interval_s() const { return 1.0 / GetParam(); }
  /// Frames whose time, from halfway before the first of them, is at most this.
  [[nodiscard]] int frames_within(double seconds) const {
    return static_cast<int>(std::floor(seconds / interval_s() + 0.5));
  }

  enum class Motion : std::uint8_t { kNoFeatures, kInCluster, kStill, kUnknown };

  /// One frame of two features, all in one cluster, at rest or of unknown motion; `with_blob`: a blob continues the
  /// region.
  void step(Motion motion, bool with_blob) {
    std::vector<Feature> features(motion == Motion::kNoFeatures ? 0 : 2);
    for (std::size_t i = 0; i < features.size(); ++i) {
      features[i].id = static_cast<std::uint32_t>(i) + 1;
      features[i].slot = static_cast<std::uint16_t>(i);
    }
    const bool in_cluster = motion == Motion::kInCluster;
    const std::vector<FeatureMotion> motions(
        features.size(),
        FeatureMotion{.known = motion != Motion::kUnknown, .covariance = 100.F * Eigen::Matrix3f::Identity()});
    const std::vector<MotionCluster> clusters(in_cluster ? 1 : 0, MotionCluster{.features = 2});
    const std::vector<std::int16_t> cluster_of_feature(features.size(),
                                                       in_cluster ? std::int16_t{0} : std::int16_t{-1});
    const std::vector<std::int16_t> blob_of_feature(features.size(), -1);
    const std::uint32_t region_id = memory_.regions().empty() ? 0 : memory_.regions()[0].id;
    const std::vector<std::uint32_t> region_of_feature(features.size(), region_id);
    MovingBlob blob;
    blob.information = Eigen::Matrix3f::Identity();
    blob.moving = true;
    memory_.begin(std::llround(1e9 * interval_s()), features, region_of_feature);
    memory_.update(features, motions, clusters, cluster_of_feature, region_of_feature);
    memory_.update_blobs(std::span(&blob, with_blob ? 1 : 0), std::span(&region_id, with_blob ? 1 : 0),
                         blob_of_feature);
    memory_.conclude(features, motions);
  }

  /// Frames of unknown motion in which the features belong to the region; its blob continues it.
  int frames_of_membership() {
    int frames = 0;
    for (step(Motion::kUnknown, true); memory_.region_of_feature()[0] == 0 && frames < 100;
         step(Motion::kUnknown, true)) {
      ++frames;
    }
    return frames;
  }

  Arena arena_{1U << 16U};
  MotionMemory memory_{MotionConfig{}, 10, arena_};
};

TEST_P(MotionMemoryTest, AnUnconfirmedRegionEndsAfterAFifthOfASecondWithoutMotion) {
  step(Motion::kInCluster, false);
  ASSERT_EQ(memory_.regions().size(), 1U);
  for (int i = 0; i < frames_within(0.2); ++i) {
    step(Motion::kUnknown, false);
    EXPECT_EQ(memory_.regions().size(), 1U) << i;
  }
  step(Motion::kUnknown, false);
  EXPECT_EQ(memory_.regions().size(), 0U);
}

// A feature is still a member in the frame in which its time passes.
TEST_P(MotionMemoryTest, AFeatureThatNeverMovedWithItsRegionLeavesItAfterTwoFifthsOfASecond) {
  step(Motion::kNoFeatures, true);
  ASSERT_EQ(memory_.regions().size(), 1U);
  EXPECT_EQ(frames_of_membership(), frames_within(0.4) + 1);
}

TEST_P(MotionMemoryTest, AFeatureThatMovedWithItsRegionLeavesItAfterFourFifthsOfASecond) {
  step(Motion::kNoFeatures, true);
  step(Motion::kInCluster, true);
  ASSERT_EQ(memory_.regions().size(), 1U);
  EXPECT_EQ(frames_of_membership(), frames_within(0.8) + 1);
}

// Its region has stopped.
TEST_P(MotionMemoryTest, AFeatureOnTheMaskOfAStoppedRegionLeavesItAfterTwoFifthsOfASecond) {
  step(Motion::kNoFeatures, true);
  int frames = 0;
  for (step(Motion::kStill, false); memory_.region_of_feature()[0] == 0 && frames < 100; step(Motion::kStill, false)) {
    ++frames;
  }
  EXPECT_EQ(frames, frames_within(0.4));
}

INSTANTIATE_TEST_SUITE_P(Rates, MotionMemoryTest, ::testing::Values(10, 30));

class TenFeatures : public ::testing::Test {
 protected:
  void SetUp() override {
    for (std::size_t i = 0; i < features_.size(); ++i) {
      features_[i].id = static_cast<std::uint32_t>(i) + 1;
      features_[i].slot = static_cast<std::uint16_t>(i);
    }
  }

  void step(const std::vector<MotionCluster>& clusters, const std::vector<std::int16_t>& cluster_of_feature) {
    const std::vector<FeatureMotion> motions(features_.size(), FeatureMotion{.known = true});
    const std::vector<std::uint32_t> none(features_.size(), 0);
    memory_.begin(100'000'000, features_, none);
    memory_.update(features_, motions, clusters, cluster_of_feature, none);
    memory_.conclude(features_, motions);
  }

  Arena arena_{1U << 16U};
  MotionMemory memory_{MotionConfig{}, 10, arena_};
  std::vector<Feature> features_ = std::vector<Feature>(10);
};

// Two vehicles side by side were one region until they were separated.
TEST_F(TenFeatures, OfASplitClusterOnePartContinuesTheRegionAndTheOtherKnowsIt) {
  step({{.features = 10}}, std::vector<std::int16_t>(10, 0));
  ASSERT_EQ(memory_.regions().size(), 1U);
  const std::uint32_t first_id = memory_.regions()[0].id;
  step({{.features = 5, .split = true}, {.features = 5, .split = true}}, {0, 0, 0, 0, 0, 1, 1, 1, 1, 1});
  ASSERT_EQ(memory_.regions().size(), 2U);
  EXPECT_EQ(memory_.regions()[0].id, first_id);
  EXPECT_EQ(memory_.regions()[0].beside, 0U);
  EXPECT_EQ(memory_.regions()[1].beside, first_id);
}

// The front and the rear of a truck were two regions until one cluster held both.
TEST_F(TenFeatures, OfTwoRegionsInOneClusterTheSmallerBecomesAPart) {
  step({{.features = 5}, {.features = 4}}, {0, 0, 0, 0, 0, 1, 1, 1, 1, -1});
  ASSERT_EQ(memory_.regions().size(), 2U);
  const std::uint32_t front = memory_.regions()[0].id;
  const std::uint32_t rear = memory_.regions()[1].id;
  step({{.features = 8}}, {0, 0, 0, 0, 0, 0, 0, 0, -1, -1});
  ASSERT_EQ(memory_.regions().size(), 1U);
  EXPECT_EQ(memory_.regions()[0].id, front);
  ASSERT_EQ(memory_.joined().size(), 1U);
  EXPECT_EQ(memory_.joined()[0].part, rear);
  EXPECT_EQ(memory_.joined()[0].whole, front);
  EXPECT_EQ(memory_.region_of_feature()[8], 0);  // in no cluster
}

TEST_F(TenFeatures, ARegionThatIsInAnotherClusterForItsSmallerPartStays) {
  step({{.features = 5}, {.features = 5}}, {0, 0, 0, 0, 0, 1, 1, 1, 1, 1});
  step({{.features = 7}, {.features = 3}}, {0, 0, 0, 0, 0, 0, 0, 1, 1, 1});
  EXPECT_EQ(memory_.regions().size(), 2U);
  EXPECT_TRUE(memory_.joined().empty());
}

}  // namespace
}  // namespace kinetrace::segmentation

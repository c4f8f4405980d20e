// Vehicles that drive alike, on a level road.
#include "kinetrace/segmentation/motion_clusters.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "synthetic_world.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr float kCameraHeightM = 1.6F;
const Eigen::Vector3f kOncoming_mps{0.F, 0.F, -8.F};

class AlikeVehicles : public ::testing::Test {
 protected:
  AlikeVehicles() {
    const ImageView<float> cells =
        take_image<float>(arena_, geometry_.width_px / kCellPx, geometry_.height_px / kCellPx);
    for (int cy = 0; cy < cells.height; ++cy) {
      const float below_horizon_px = cell_center(cy) - static_cast<float>(geometry_.cy_px);
      const float ground_px = below_horizon_px * static_cast<float>(geometry_.baseline_m) / kCameraHeightM;
      std::fill_n(cells.row(cy), cells.width, std::max(ground_px, 1.F));
    }
    ground_.fit(cells, 1);
    history_.push({}, Se3{}, 0);
    disparity_.clear();
  }

  /// Features on a vehicle's front and side: from `left_m` to `right_m`, and from `near_m` to `far_m` away.
  void add_vehicle(float left_m, float right_m, float near_m, float far_m, const Eigen::Vector3f& velocity_mps) {
    for (const float height_m : {0.5F, 1.F}) {
      for (int k = 0; k < 5; ++k) {
        const float part = 0.25F * static_cast<float>(k);
        add_feature({left_m + part * (right_m - left_m), kCameraHeightM - height_m, near_m}, velocity_mps);
        add_feature({right_m, kCameraHeightM - height_m, near_m + part * (far_m - near_m)}, velocity_mps);
      }
    }
  }

  void add_feature(const Eigen::Vector3f& p, const Eigen::Vector3f& velocity_mps) {
    const auto fx = static_cast<float>(geometry_.fx_px);
    Feature f;
    f.id = static_cast<std::uint32_t>(features_.size()) + 1;
    f.left_px = {fx * p.x() / p.z() + static_cast<float>(geometry_.cx_px),
                 static_cast<float>(geometry_.fy_px) * p.y() / p.z() + static_cast<float>(geometry_.cy_px)};
    f.v_px = f.left_px.y();
    f.u_right_px = f.left_px.x() - fx * static_cast<float>(geometry_.baseline_m) / p.z();
    features_.push_back(f);
    FeatureMotion motion{.known = true, .depth_m = p.z(), .velocity_mps = velocity_mps};
    motion.covariance.diagonal() << 0.04F, 0.04F, 1.F;
    motion.information = motion.covariance.inverse();
    motion.static_chi2 = velocity_mps.dot(motion.information * velocity_mps);
    motions_.push_back(motion);
  }

  std::span<const MotionCluster> find() {
    const std::vector<std::int16_t> no_region(features_.size(), -1);
    return clusters_.find(features_, motions_, 0.0, {disparity_, ground_, history_}, test_, no_region);
  }

  StereoGeometry geometry_ = test::street_rig();
  Arena arena_{1U << 24U};
  GroundPlane ground_{geometry_, arena_};
  FrameHistory history_{geometry_.width_px, geometry_.height_px, arena_};
  CellDisparity disparity_{geometry_, arena_};
  TemporalTest test_{geometry_, history_};
  MotionClusters clusters_{MotionConfig{}, geometry_, 100, arena_};
  std::vector<Feature> features_;
  std::vector<FeatureMotion> motions_;
};

TEST_F(AlikeVehicles, BesideEachOtherAreTwo) {
  ASSERT_TRUE(ground_.known());
  add_vehicle(-6.5F, -4.7F, 25.F, 26.F, kOncoming_mps);
  add_vehicle(-3.F, -1.2F, 24.F, 25.F, {0.F, 0.F, -7.F});
  const std::span<const MotionCluster> found = find();
  ASSERT_EQ(found.size(), 2U);
  for (const MotionCluster& cluster : found) {
    EXPECT_TRUE(cluster.split);
    EXPECT_EQ(cluster.features, 20);
  }
  EXPECT_EQ(clusters_.cluster_of_feature()[0], clusters_.cluster_of_feature()[19]);
  EXPECT_NE(clusters_.cluster_of_feature()[0], clusters_.cluster_of_feature()[20]);
}

TEST_F(AlikeVehicles, ATruckIsOne) {
  add_vehicle(-4.F, -1.5F, 20.F, 28.F, kOncoming_mps);
  const std::span<const MotionCluster> found = find();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_FALSE(found[0].split);
}

// Its side is plain.
TEST_F(AlikeVehicles, ATruckWithFeaturesAtItsEndsIsOne) {
  add_vehicle(-4.F, -1.5F, 10.F, 10.2F, kOncoming_mps);
  add_vehicle(-1.6F, -1.5F, 16.F, 16.2F, kOncoming_mps);
  EXPECT_EQ(find().size(), 1U);
}

TEST_F(AlikeVehicles, OneBehindTheOtherAreTwo) {
  add_vehicle(-4.F, -2.F, 10.F, 14.F, kOncoming_mps);
  add_vehicle(-4.F, -2.F, 22.F, 26.F, kOncoming_mps);
  EXPECT_EQ(find().size(), 2U);
}

// Its length is across the camera's view, and along its motion.
TEST_F(AlikeVehicles, ACrossingTruckIsOne) {
  for (int k = 0; k < 20; ++k) {
    add_feature({-4.F + 0.4F * static_cast<float>(k), 0.6F, 20.F}, {8.F, 0.F, 0.F});
  }
  ASSERT_EQ(find().size(), 1U);
}

// Depths are too uncertain there to tell a width.
TEST_F(AlikeVehicles, ACrossingCarFarAwayIsOne) {
  for (int k = 0; k < 20; ++k) {
    const float depth_error_m = k % 2 == 0 ? 3.F : -3.F;
    add_feature({-2.F + 0.2F * static_cast<float>(k), 0.6F, 50.F + depth_error_m}, {8.F, 0.F, 0.F});
  }
  ASSERT_EQ(find().size(), 1U);
}

}  // namespace
}  // namespace kinetrace::segmentation

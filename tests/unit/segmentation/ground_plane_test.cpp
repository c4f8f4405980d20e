#include "kinetrace/segmentation/ground_plane.hpp"

#include <gtest/gtest.h>

#include "kinetrace/segmentation/cell_disparity.hpp"
#include "synthetic_world.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr float kCameraHeightM = 1.6F;

class GroundPlaneTest : public ::testing::Test {
 protected:
  GroundPlaneTest() : cells_(take_image<float>(arena_, geometry_.width_px / kCellPx, geometry_.height_px / kCellPx)) {}

  /// Disparity of the ground, flat and level, at row v.
  [[nodiscard]] float ground_px(float v) const {
    return (v - static_cast<float>(geometry_.cy_px)) * static_cast<float>(geometry_.baseline_m) / kCameraHeightM;
  }
  /// Disparity of a point `height_m` above the ground, on the ray through row v.
  [[nodiscard]] float above_px(float v, float height_m) const {
    return ground_px(v) / (1.F - height_m / kCameraHeightM);
  }
  /// Ground below the horizon; a wall with disparity `wall_px` above it and where the wall is nearer.
  void draw(float wall_px) {
    for (int cy = 0; cy < cells_.height; ++cy) {
      for (int cx = 0; cx < cells_.width; ++cx) {
        cells_.row(cy)[cx] = std::max(wall_px, ground_px(cell_center(cy)));
      }
    }
  }
  StereoGeometry geometry_ = test::street_rig();
  Arena arena_{1U << 20U};
  ImageView<float> cells_;
  GroundPlane ground_{geometry_, arena_};
};

TEST_F(GroundPlaneTest, TellsGroundFromWhatStandsOnIt) {
  draw(8.F);
  ground_.fit(cells_, 1);
  ASSERT_TRUE(ground_.known());
  for (const float v : {230.F, 300.F, 360.F}) {
    EXPECT_LT(ground_.object_nats(600.F, v, ground_px(v), 0.4F), -1.5F) << v;
    EXPECT_GT(ground_.object_nats(600.F, v, above_px(v, 0.8F), 0.4F), 1.F) << v;
    EXPECT_FALSE(ground_.may_hold_object(600.F, v, ground_px(v), 0.2F)) << v;
    EXPECT_TRUE(ground_.may_hold_object(600.F, v, above_px(v, 0.8F), 0.2F)) << v;
  }
  // At row 20 and 20 m the place is six metres above the ground.
  EXPECT_FALSE(ground_.may_hold_object(600.F, 20.F, 19.5F, 0.2F));
}

TEST_F(GroundPlaneTest, IsLessSureWhereNoiseIsAsHighAsObjectsAre) {
  draw(4.F);
  ground_.fit(cells_, 1);
  ASSERT_TRUE(ground_.known());
  const float v = 300.F;
  EXPECT_GT(ground_.object_nats(600.F, v, ground_px(v), 20.F), ground_.object_nats(600.F, v, ground_px(v), 0.2F) + 1.F);
}

// A street between hedges: one cell in eleven shows the road.
TEST_F(GroundPlaneTest, IsFoundThoughLittleOfItIsTextured) {
  draw(8.F);
  int on_road = 0;
  for (int cy = 0; cy < cells_.height; ++cy) {
    for (int cx = 0; cx < cells_.width; ++cx) {
      const float u = cell_center(cx);
      const float v = cell_center(cy);
      const bool is_road = v > 250.F && std::abs(u - 600.F) < 160.F;
      on_road += is_road ? 1 : 0;
      // The hedges stand two metres beside the camera.
      cells_.row(cy)[cx] = is_road ? ground_px(v) : std::max(8.F, std::abs(u - 600.F) / 2.F * 0.54F);
    }
  }
  ASSERT_LT(11 * on_road, cells_.width * cells_.height);
  int frames = 0;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    ground_.fit(cells_, seed * 2654435761U);
    frames += ground_.known() && ground_.normal().y() > 0.98F ? 1 : 0;
  }
  EXPECT_GE(frames, 17);
}

TEST_F(GroundPlaneTest, AWallIsNoGround) {
  draw(300.F);  // nearer than the ground everywhere
  ground_.fit(cells_, 1);
  EXPECT_FALSE(ground_.known());
  EXPECT_EQ(ground_.object_nats(600.F, 300.F, 50.F, 0.4F), 0.F);
  EXPECT_TRUE(ground_.may_hold_object(600.F, 300.F, 50.F, 0.4F));
}

TEST_F(GroundPlaneTest, WithoutDisparitiesItKeepsWhatItKnew) {
  draw(8.F);
  ground_.fit(cells_, 1);
  for (int cy = 0; cy < cells_.height; ++cy) {
    std::fill_n(cells_.row(cy), cells_.width, -1.F);
  }
  ground_.fit(cells_, 2);
  EXPECT_TRUE(ground_.known());
  ground_.clear();
  EXPECT_FALSE(ground_.known());
}

}  // namespace
}  // namespace kinetrace::segmentation

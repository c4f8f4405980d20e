// The remembered mask of a partly occluded object: never larger than the object was.
#include <array>

#include <gtest/gtest.h>

#include "mask_scene.hpp"

namespace kinetrace::tracking {
namespace {

constexpr Shape kWall{.x = 300.0, .y = 120.0, .half_width = 100.0, .half_height = 30.0, .disparity_px = 20.0};
constexpr Shape kFarCar{.x = 300.0, .y = 88.0, .half_width = 16.0, .half_height = 12.0, .disparity_px = 4.0};
constexpr double kVisiblePart = 0.5;  // Of the car, above the wall.

/// The car is fully visible above the wall, then half behind it for `frames`.
float visible_part_after(TrackerScene& scene, int frames) {
  Shape above = kFarCar;
  above.y -= 30.0;
  for (int i = 0; i < 16; ++i) {
    above.y += 2.0;
    scene.step(std::array{kWall, above});
  }
  for (int i = 0; i <= frames; ++i) {
    scene.step(std::array{kWall, kFarCar});
  }
  return scene.track_of(1) == nullptr ? 0.F : scene.track_of(1)->visible_part;
}

TEST(HiddenMask, NeitherGrowsNorShrinksByTheNoiseOfFewFeatures) {
  for (const int features : {3, 4}) {
    TrackerScene scene({}, features);
    scene.feature_noise_px = 0.5;
    const float visible = visible_part_after(scene, 90);
    EXPECT_EQ(scene.track_of(1)->id, 2U);
    EXPECT_NEAR(visible, kVisiblePart, 0.12) << features;
  }
}

TEST(HiddenMask, SlidesAlongWhereItIsPredictedBesideWhatIsSeen) {
  TrackerScene scene({}, 1);
  scene.feature_noise_px = 1.0;
  const float visible = visible_part_after(scene, 90);
  EXPECT_EQ(scene.track_of(1)->id, 2U);
  EXPECT_GT(visible, 0.8 * kVisiblePart);
}

TEST(HiddenMask, GrowsWithWhatManyFeaturesShow) {
  TrackerScene scene({}, 24);
  Shape wall = kWall;
  wall.x = 320.0;
  wall.y = 120.0;
  Shape car{.x = 320.0, .y = 90.0, .half_width = 40.0, .half_height = 30.0, .disparity_px = 5.0};
  scene.step(std::array{wall, car});
  for (int i = 0; i < 20; ++i) {
    for (Shape* shape : {&wall, &car}) {
      shape->half_width *= 1.02;
      shape->half_height *= 1.02;
      shape->y = 120.0 + 1.02 * (shape->y - 120.0);
    }
    scene.step(std::array{wall, car});
  }
  ASSERT_NE(scene.track_of(1), nullptr);
  EXPECT_EQ(scene.track_of(1)->id, 2U);
  EXPECT_GT(scene.left_iou(*scene.track_of(1), 1), 0.9);
}

TEST(HiddenMask, GrowsAsItsPredictionComesNearer) {
  // The car approaches behind a static wall, with too few features to show it.
  TrackerScene scene({}, 4);
  Shape car = kFarCar;
  car.y = 60.0;
  double depth_m = 40.0;
  const auto step = [&] {
    scene.object_predictions = {{}, {.known = true, .point_px = {car.x, car.y}, .depth_m = depth_m}};
    scene.step(std::array{kWall, car});
  };
  for (int i = 0; i < 15; ++i) {
    step();
    car.y += 2.0;
  }
  for (int i = 0; i < 30; ++i) {
    step();
    depth_m /= 1.03;
    car.half_width *= 1.03;
    car.half_height *= 1.03;
  }
  ASSERT_NE(scene.track_of(1), nullptr);
  EXPECT_EQ(scene.track_of(1)->id, 2U);
  EXPECT_NEAR(scene.track_of(1)->visible_part, kVisiblePart, 0.12);
}

TEST(HiddenMask, IsVisibleWhereBothCamerasSeeIt) {
  TrackerScene scene({}, 4);
  const Shape near_border{.x = 40.0, .y = 100.0, .disparity_px = 40.0};  // The right view sees half of it.
  for (int i = 0; i < 4; ++i) {
    scene.step(std::array{near_border});
  }
  ASSERT_NE(scene.track_of(0), nullptr);
  EXPECT_NEAR(scene.track_of(0)->visible_part, 0.5, 0.05);
}

TEST(HiddenMask, StereoTellsWhichIsInFrontWhereMasksErr) {
  TrackerScene scene({}, 24);
  (void)visible_part_after(scene, 4);
  Shape lower = kWall;  // As if the wall's mask missed its upper edge, where the car appears instead.
  lower.y += 5.0;
  lower.half_height -= 5.0;
  scene.step(std::array{lower, kFarCar});
  for (int i = 0; i < 4; ++i) {
    scene.step(std::array{kWall, kFarCar});
  }
  ASSERT_NE(scene.track_of(1), nullptr);
  EXPECT_NEAR(scene.track_of(1)->visible_part, kVisiblePart, 0.12);
}

TEST(HiddenMask, KeepsItsShapeWhileWhatHidesItIsNotDetected) {
  TrackerScene scene({}, 24);
  (void)visible_part_after(scene, 4);
  // An object on the wall hides more of the car, and neither it nor the wall is detected: the gap has no label.
  const Shape on_the_wall{.x = 300.0, .y = 86.0, .half_width = 20.0, .half_height = 4.0, .disparity_px = 20.0};
  scene.detected = {false, true, false};
  scene.step(std::array{kWall, kFarCar, on_the_wall});
  scene.detected.clear();
  scene.step(std::array{kWall, kFarCar});
  ASSERT_NE(scene.track_of(1), nullptr);
  EXPECT_EQ(scene.track_of(1)->id, 2U);
  EXPECT_NEAR(scene.track_of(1)->visible_part, kVisiblePart, 0.12);
}

/// The box with these sides, px, at the wall's disparity; of a camera with a focal length of 1 px and a baseline of 1
/// m.
PredictedVolume box_before_the_car(double x0, double y0, double x1, double y1) {
  PredictedVolume volume;
  volume.half_size_m = Eigen::Vector3d(0.5 * (x1 - x0), 0.5 * (y1 - y0), 0.05) / kWall.disparity_px;
  volume.T_box_stereo << 1.0, 0.0, 0.0, -0.5 * (x0 + x1),  //
      0.0, 1.0, 0.0, -0.5 * (y0 + y1),                     //
      0.0, 0.0, -1.0 / kWall.disparity_px, 1.0,            //
      0.0, 0.0, 1.0, 0.0;
  return volume;
}

TEST(PredictedVolumeTest, HidesWhatIsBehindIt) {
  const PredictedVolume volume = box_before_the_car(200.0, 60.0, 400.0, 150.0);
  EXPECT_TRUE(volume.hides({300.0, 100.0}, kFarCar.disparity_px));
  EXPECT_TRUE(volume.hides({205.0, 65.0}, kFarCar.disparity_px));
  EXPECT_FALSE(volume.hides({300.0, 100.0}, 2.0 * kWall.disparity_px)) << "nearer";
  EXPECT_FALSE(volume.hides({420.0, 100.0}, kFarCar.disparity_px)) << "beside it";
}

// The mask of the wall misses its upper part, behind which the car passes.
TEST(HiddenMask, IsNotExpectedBehindTheBoxOfAnObjectWhoseMaskLacksAPart) {
  for (const bool is_behind : {true, false}) {
    TrackerScene scene({}, 24);
    Shape car = kFarCar;
    car.y = 70.0;
    for (int i = 0; i < 4; ++i) {
      scene.step(std::array{kWall, car});
    }
    scene.object_predictions = {
        {.known = true, .point_px = {kWall.x, kWall.y}, .depth_m = 2.0, .disparity_px = kWall.disparity_px},
        {.known = true, .point_px = {car.x, car.y}, .depth_m = 10.0, .disparity_px = car.disparity_px}};
    scene.object_predictions[0].volume = box_before_the_car(is_behind ? 200.0 : 320.0, 50.0, 400.0, 150.0);
    scene.detected = {true, false};
    scene.step(std::array{kWall, car});
    scene.step(std::array{kWall, car});
    ASSERT_EQ(scene.frame().tracks.size(), 2U);
    EXPECT_EQ(scene.frame().tracks[1].area_px == 0, is_behind);
  }
}

}  // namespace
}  // namespace kinetrace::tracking

#include "kinetrace/evaluation/box_metrics.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "kinetrace/evaluation/box_overlap.hpp"
#include "object_scene.hpp"

namespace kinetrace::evaluation {
namespace {

OrientedBox box_at(const Eigen::Vector3d& center_m, const Eigen::Vector3d& size_m, double yaw_rad = 0.0) {
  return {{so3_exp({0.0, yaw_rad, 0.0}), center_m}, size_m};
}

TEST(BoxOverlap, OfABoxWithItselfIsOne) {
  const OrientedBox car = box_at({1.0, 2.0, 30.0}, {4.2, 1.5, 1.8}, 0.7);
  EXPECT_NEAR(overlap(car, car).iou_3d, 1.0, 1e-9);
  EXPECT_NEAR(overlap(car, car).iou_footprint, 1.0, 1e-9);
}

TEST(BoxOverlap, OfShiftedBoxesIsThatOfTheirIntervals) {
  const OrientedBox car = box_at({0.0, 0.0, 10.0}, {4.0, 1.5, 2.0});
  EXPECT_NEAR(overlap(car, box_at({2.0, 0.0, 10.0}, {4.0, 1.5, 2.0})).iou_3d, 1.0 / 3.0, 1e-9);
  const BoxOverlap lifted = overlap(car, box_at({0.0, 0.75, 10.0}, {4.0, 1.5, 2.0}));
  EXPECT_NEAR(lifted.iou_3d, 1.0 / 3.0, 1e-9);
  EXPECT_NEAR(lifted.iou_footprint, 1.0, 1e-9) << "seen from above, height does not count";
  EXPECT_EQ(overlap(car, box_at({5.0, 0.0, 10.0}, {4.0, 1.5, 2.0})).iou_3d, 0.0);
  EXPECT_EQ(overlap(car, box_at({0.0, 0.0, 10.0}, {0.0, 1.5, 2.0})).iou_3d, 0.0) << "no volume";
}

TEST(BoxOverlap, OfSquaresTurnedAgainstEachOtherIsAnOctagon) {
  const OrientedBox square = box_at({0.0, 0.0, 10.0}, {1.0, 2.0, 1.0});
  const BoxOverlap turned = overlap(square, box_at({0.0, 0.0, 10.0}, {1.0, 2.0, 1.0}, 0.25 * std::numbers::pi));
  const double octagon = 2.0 * (std::sqrt(2.0) - 1.0);
  EXPECT_NEAR(turned.iou_footprint, octagon / (2.0 - octagon), 1e-9);
  EXPECT_NEAR(turned.iou_3d, octagon / (2.0 - octagon), 1e-9);
}

TEST(BoxOverlap, OfTiltedBoxesIsThatOfTheirVolumes) {
  const OrientedBox cube = box_at({0.0, 0.0, 10.0}, {1.0, 1.0, 1.0});
  OrientedBox tilted = cube;
  tilted.T_world_box.rotation = so3_exp({0.25 * std::numbers::pi, 0.0, 0.0});
  const double octagon = 2.0 * (std::sqrt(2.0) - 1.0);
  EXPECT_NEAR(overlap(cube, tilted).iou_3d, octagon / (2.0 - octagon), 1e-9);
}

TEST(BoxErrors, TurnsByHalfACircleCountApart) {
  const OrientedBox truth = box_at({0.0, 0.0, 10.0}, {4.0, 1.5, 1.8}, 0.3);
  BoxErrors errors;
  const Box3 turned{{0.0, 0.0, 10.0}, {4.0, 1.5, 1.8}, 0.3 + std::numbers::pi};
  compare(truth, turned, {{0.1, 0.1, 0.1}, {0.1, 0.1, 0.1}, 0.1, true}, errors);
  compare(truth, turned, {{0.1, 0.1, 0.1}, {0.1, 0.1, 0.1}, 0.1, false}, errors);
  EXPECT_NEAR(errors.yaw_deg.max().value(), 0.0, 1e-6);
  EXPECT_NEAR(errors.iou_3d.mean().value(), 1.0, 1e-6);
  EXPECT_EQ(errors.known_headings, 1U);
  EXPECT_EQ(errors.known_turned, 1U);
}

TEST(BoxErrors, AreHeldAgainstTheirStandardDeviations) {
  const OrientedBox truth = box_at({0.0, 0.0, 10.0}, {4.0, 1.5, 1.8});
  BoxErrors errors;
  compare(truth, Box3{{0.2, 0.0, 10.0}, {4.4, 1.5, 1.8}, 0.05}, {{0.1, 1.0, 1.0}, {0.2, 1.0, 1.0}, 0.05, false},
          errors);
  EXPECT_NEAR(errors.center_normalised.mean_square().value(), 4.0 / 3.0, 0.02);
  EXPECT_NEAR(errors.size_normalised.mean_square().value(), 4.0 / 3.0, 1e-9);
  EXPECT_NEAR(errors.yaw_normalised.mean_square().value(), 1.0, 1e-9);
  BoxErrors unknown;
  compare(truth, Box3{{0.2, 0.0, 10.0}, {4.4, 1.5, 1.8}, 0.05}, {}, unknown);
  EXPECT_FALSE(unknown.center_normalised.mean_square().has_value()) << "a run that does not say how sure it is";
}

TEST(BoxMetrics, AreByMotionDistanceAndStage) {
  std::vector<ObjectFrame> scene = perfect_scene();
  for (ObjectFrame& frame : scene) {
    frame.truth[1].hidden = 0.6;
  }
  BoxMetrics boxes = evaluate_objects(scene, {}).boxes;
  constexpr auto kFrames = static_cast<std::size_t>(kSceneFrames);
  EXPECT_EQ(boxes.cell(true, 15.0, BoxStage::kEarly).iou_3d.count(), static_cast<std::size_t>(kEarlyFrames));
  EXPECT_EQ(boxes.cell(true, 15.0, BoxStage::kSeen).iou_3d.count(), kFrames - kEarlyFrames);
  EXPECT_EQ(boxes.cell(false, 15.0, BoxStage::kHidden).iou_3d.count(), kFrames - kEarlyFrames);
  EXPECT_EQ(boxes.cell(true, 25.0, BoxStage::kSeen).iou_3d.count(), 0U);
  EXPECT_NEAR(boxes.cell(true, 15.0, BoxStage::kSeen).iou_3d.mean().value(), 1.0, 1e-9);
}

}  // namespace
}  // namespace kinetrace::evaluation

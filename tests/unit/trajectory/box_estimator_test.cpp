#include "kinetrace/trajectory/box_estimator.hpp"

#include <cmath>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "kinetrace/core/allocation_counter.hpp"

namespace kinetrace::trajectory {
namespace {

const double kUnknown = std::nan("");
constexpr double kPi = std::numbers::pi;
const Eigen::Vector3d kCar(4.2, 1.5, 1.8);  // Length, height, width.

enum class Faces { kAll, kRear, kRearAndSide };

/// Points on the walls of a car whose front points along `yaw_rad` (KITTI rotation_y), its centre at `center`.
std::vector<BodyPoint> car_points(int count, double yaw_rad, Faces faces, const Eigen::Vector3d& center = {0, 0, 0},
                                  unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  std::vector<BodyPoint> points;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d p{uniform(random), uniform(random), uniform(random)};  // Braces: drawn in this order everywhere.
    const int face = faces == Faces::kRear ? 0 : (faces == Faces::kRearAndSide ? i % 2 : i % 4);
    switch (face) {
      case 0: p.x() = -0.5; break;
      case 1: p.z() = 0.5; break;
      case 2: p.x() = 0.5; break;
      default: p.z() = -0.5; break;
    }
    const Eigen::Vector3d local = p.cwiseProduct(kCar);
    BodyPoint point;
    point.position_m = (center + so3_exp({0.0, yaw_rad, 0.0}) * local).cast<float>();
    points.push_back(point);
  }
  return points;
}

struct Estimator {
  explicit Estimator(std::size_t max_points = 400, const TrajectoryConfig& config = {})
      : arena(std::size_t{1} << 16U), box(config, max_points, arena) {}
  Arena arena;
  BoxEstimator box;
};

void expect_car(const Box3& box, double tolerance_m) {
  EXPECT_NEAR(box.size_m.x(), kCar.x(), tolerance_m);
  EXPECT_NEAR(box.size_m.y(), kCar.y(), tolerance_m);
  EXPECT_NEAR(box.size_m.z(), kCar.z(), tolerance_m);
}

TEST(BoxEstimator, KnowsNothingFromFewerThanFourPoints) {
  Estimator estimator;
  estimator.box.update({}, kUnknown);
  EXPECT_FALSE(estimator.box.known());
  std::vector<BodyPoint> corners(4);  // Near each other: what lies beyond a gap would not count.
  corners[1].position_m = {1.F, 0.F, 0.F};
  corners[2].position_m = {0.F, 1.F, 0.F};
  corners[3].position_m = {0.F, 0.F, 1.F};
  estimator.box.update(std::span(corners).first(3), 0.0);
  EXPECT_FALSE(estimator.box.known());
  estimator.box.update(corners, 0.0);
  EXPECT_TRUE(estimator.box.known());
  estimator.box.reset();
  EXPECT_FALSE(estimator.box.known());
}

TEST(BoxEstimator, FitsACarWithKnownHeadingWhateverTheHeading) {
  for (const double yaw_rad : {0.0, 0.4, 0.5 * kPi, -2.0, 3.0}) {
    Estimator estimator;
    const Eigen::Vector3d center(0.3, -0.2, 0.9);
    const auto points = car_points(300, yaw_rad, Faces::kAll, center);
    estimator.box.update(points, yaw_rad);
    expect_car(estimator.box.box_in_object(), 0.2);
    EXPECT_NEAR(std::remainder(estimator.box.box_in_object().yaw_rad - yaw_rad, 2.0 * kPi), 0.0, 1e-9);
    EXPECT_LT((estimator.box.box_in_object().center_m - center).norm(), 0.15);
  }
}

TEST(BoxEstimator, FindsTheMainDirectionWithoutHeading) {
  for (const double yaw_rad : {0.0, 0.6, -1.2}) {
    Estimator estimator;
    const auto points = car_points(400, yaw_rad, Faces::kAll);
    estimator.box.update(points, kUnknown);
    expect_car(estimator.box.box_in_object(), 0.35);
    EXPECT_NEAR(std::remainder(estimator.box.box_in_object().yaw_rad - yaw_rad, kPi), 0.0, 0.05);
  }
}

TEST(BoxEstimator, IgnoresFarOutliersAndPointsThatAreNotFinite) {
  Estimator estimator;
  auto points = car_points(200, 0.3, Faces::kAll);
  for (int i = 0; i < 30; ++i) {
    BodyPoint stray;
    stray.position_m = {8.F + 0.3F * static_cast<float>(i), -3.F, 12.F};
    points.push_back(stray);
  }
  points[5].position_m.x() = std::numeric_limits<float>::quiet_NaN();
  estimator.box.update(points, 0.3);
  expect_car(estimator.box.box_in_object(), 0.25);
}

TEST(BoxEstimator, GrowsWithNewViewsWithoutJumpingAndKeepsThemOutOfView) {
  Estimator estimator;
  const auto rear = car_points(100, 0.0, Faces::kRear);
  estimator.box.update(rear, 0.0);
  EXPECT_LT(estimator.box.box_in_object().size_m.x(), 0.3);
  const auto both = car_points(200, 0.0, Faces::kRearAndSide);
  double last_m = estimator.box.box_in_object().size_m.x();
  for (int i = 0; i < 40; ++i) {
    estimator.box.update(both, 0.0);
    const double now_m = estimator.box.box_in_object().size_m.x();
    EXPECT_LE(now_m - last_m, 0.31);
    EXPECT_GE(now_m, last_m - 0.007);
    last_m = now_m;
  }
  // The percentile takes 3 % of all points off the end of the side, which holds half of them.
  expect_car(estimator.box.box_in_object(), 0.45);
  for (int i = 0; i < 20; ++i) {
    estimator.box.update(rear, 0.0);
  }
  EXPECT_GT(estimator.box.box_in_object().size_m.x(), last_m - 0.1);
}

TEST(BoxEstimator, HeadingRelabelsQuartersAndTurnsTheRestGradually) {
  Estimator estimator;
  // Without heading, length is along the main direction; then the object turns out to move sideways to it.
  const auto points = car_points(400, 0.0, Faces::kAll);
  estimator.box.update(points, kUnknown);
  const Eigen::Vector3d before = estimator.box.box_in_object().size_m;
  const double front_rad = estimator.box.box_in_object().yaw_rad + 0.5 * kPi;
  estimator.box.update(points, front_rad);
  EXPECT_NEAR(estimator.box.box_in_object().size_m.x(), before.z(), 0.05);
  EXPECT_NEAR(estimator.box.box_in_object().size_m.z(), before.x(), 0.05);
  EXPECT_NEAR(std::remainder(estimator.box.box_in_object().yaw_rad - front_rad, 2.0 * kPi), 0.0, 1e-9);
  estimator.box.update(points, front_rad + 0.5);
  const double turned = std::remainder(estimator.box.box_in_object().yaw_rad - front_rad, 2.0 * kPi);
  EXPECT_GT(turned, 0.01);
  EXPECT_LT(turned, 0.1);
}

TEST(BoxEstimator, HoldsTheLastHeadingWhenItIsUnknownAgain) {
  Estimator estimator;
  const auto points = car_points(300, 0.0, Faces::kAll);
  estimator.box.update(points, kPi);
  for (int i = 0; i < 5; ++i) {
    estimator.box.update(points, kUnknown);
  }
  EXPECT_NEAR(std::abs(estimator.box.box_in_object().yaw_rad), kPi, 1e-9);
}

TEST(BoxEstimator, ClampsTheSmallestEdge) {
  TrajectoryConfig config;
  config.min_box_size_m = 0.25;
  Estimator estimator(100, config);
  std::vector<BodyPoint> points(10);
  estimator.box.update(points, kUnknown);
  EXPECT_TRUE(estimator.box.box_in_object().size_m.isApprox(Eigen::Vector3d::Constant(0.25)));
}

TEST(BoxEstimator, UsesPointsEvenlyBeyondItsCapacity) {
  Estimator exact(100);
  const auto hundred = car_points(100, 0.0, Faces::kAll);
  exact.box.update(hundred, 0.0);
  expect_car(exact.box.box_in_object(), 0.4);
  Estimator beyond(100);
  const auto many = car_points(1001, 0.0, Faces::kAll);
  beyond.box.update(many, 0.0);
  expect_car(beyond.box.box_in_object(), 0.4);
  Estimator none(0);
  none.box.update(hundred, 0.0);
  EXPECT_FALSE(none.box.known());
}

TEST(BoxEstimator, PlacesTheBoxInTheWorldWithKittiRotation) {
  Estimator estimator;
  const auto points = car_points(300, 0.2, Faces::kAll, {1.0, 0.0, 0.0});
  estimator.box.update(points, 0.2);
  const Se3 T_world_obj{so3_exp({0.0, 1.0, 0.0}), {5.0, 1.0, 30.0}};
  const Box3 box = estimator.box.box_in_world(T_world_obj);
  EXPECT_NEAR(box.yaw_rad, 1.2, 1e-9);
  EXPECT_LT((box.center_m - T_world_obj * estimator.box.box_in_object().center_m).norm(), 1e-12);
  EXPECT_EQ(box.size_m, estimator.box.box_in_object().size_m);
}

TEST(BoxEstimator, DoesNotAllocate) {
  if (!allocation_counting_available()) {
    GTEST_SKIP() << "allocations are not counted in this build";
  }
  Estimator estimator;
  const auto points = car_points(300, 0.0, Faces::kAll);
  const std::uint64_t before = allocation_counts().own;
  estimator.box.update(points, kUnknown);
  estimator.box.update(points, 0.3);
  EXPECT_EQ(allocation_counts().own - before, 0U);
}

}  // namespace
}  // namespace kinetrace::trajectory

#include <cmath>
#include <numbers>

#include "figure/figure_plan.hpp"
#include "figure/figure_views.hpp"

namespace kinetrace::figure {
namespace {

constexpr StereoGeometry kGeometry{200.0, 200.0, 160.0, 80.0, 0.5, 320, 160};
constexpr ImagePlace kPlace{{0, 0, 320, 160}, 320, 160};
using drawing::Point;
using drawing::Rect;

TEST(Box, HasTwelveEdges) {
  const Box3 box{{1.0, 2.0, 3.0}, {4.0, 1.0, 2.0}, 0.0};
  EXPECT_EQ(edges_of(box).size(), 12U);
  double length = 0.0;
  for (const Line3& edge : edges_of(box)) {
    length += (edge[1] - edge[0]).norm();
  }
  EXPECT_NEAR(length, 4 * (4.0 + 1.0 + 2.0), 1e-12);
}

TEST(ProjectLines, FollowsThePinhole) {
  const std::vector<Line2> images = project_lines({{{0.0, 0.0, 10.0}, {1.0, -0.5, 10.0}}}, kGeometry, kPlace);
  ASSERT_EQ(images.size(), 1U);
  // Pixel centres: image (160, 80) is (160.5, 80.5) on a canvas of the same size.
  EXPECT_TRUE(images[0][0].isApprox(Point(160.5, 80.5)));
  EXPECT_TRUE(images[0][1].isApprox(Point(180.5, 70.5)));
  const ImagePlace half{{100, 50, 160, 80}, 320, 160};
  EXPECT_TRUE(project_lines({{{0.0, 0.0, 10.0}, {1.0, -0.5, 10.0}}}, kGeometry, half)[0][1].isApprox(
      Point(100 + 180.5 / 2, 50 + 70.5 / 2)));
}

TEST(ProjectLines, CutsWhatLiesBehindTheCamera) {
  EXPECT_TRUE(project_lines({{{0.0, 0.0, -1.0}, {1.0, 0.0, -5.0}}}, kGeometry, kPlace).empty());
  const std::vector<Line2> images = project_lines({{{1.0, 0.0, -1.0}, {1.0, 0.0, 1.0}}}, kGeometry, kPlace);
  ASSERT_EQ(images.size(), 1U);
  EXPECT_NEAR(images[0][0].x(), 200.0 / kMinProjectionDepth_m + 160.5, 1e-6);
  EXPECT_NEAR(images[0][1].x(), 360.5, 1e-9);
  const double nan = std::nan("");
  EXPECT_TRUE(project_lines({{{nan, 0.0, 1.0}, {1.0, 0.0, 1.0}}}, kGeometry, kPlace).empty());
}

std::vector<Eigen::Vector3d> cube(double half) {
  std::vector<Eigen::Vector3d> points;
  for (const double x : {-half, 0.0, half}) {
    for (const double y : {-half, 0.0, half}) {
      for (const double z : {-half, 0.0, half}) {
        points.emplace_back(x, y, z);
      }
    }
  }
  return points;
}

TEST(Onlooker, SeesItsSubjectWithinTheArea) {
  const Rect area{100, 50, 400, 200};
  const auto points = cube(2.0);
  const Onlooker onlooker({}, {points, 0.0, {}}, area);
  for (const Eigen::Vector3d& p : points) {
    EXPECT_TRUE(area.contains(onlooker.to_canvas(p)));
  }
  EXPECT_TRUE(onlooker.to_canvas(Eigen::Vector3d::Zero()).isApprox(area.center(), 1e-9));
  // x to the right, y down, nearer things larger.
  EXPECT_GT(onlooker.to_canvas(Eigen::Vector3d(1, 0, 0)).x(), area.center().x());
  EXPECT_GT(onlooker.to_canvas(Eigen::Vector3d(0, 1, 0)).y(), area.center().y());
  EXPECT_GT(onlooker.to_canvas(Eigen::Vector3d(1, 0, -2)).x(), onlooker.to_canvas(Eigen::Vector3d(1, 0, 2)).x());
  EXPECT_LT(onlooker.distance_m({0, 0, -2}), onlooker.distance_m({0, 0, 2}));
}

TEST(Onlooker, RisesAboveAndWalksToTheLeft) {
  const auto points = cube(2.0);
  const Rect area{0, 0, 400, 400};
  Onlooker::Direction direction;
  direction.elevated_rad = 0.5;
  const Onlooker above(direction, {points, 0.0, {}}, area);
  // Points behind are higher in the picture.
  EXPECT_LT(above.to_canvas(Eigen::Vector3d(0, 0, 2)).y(), above.to_canvas(Eigen::Vector3d(0, 0, -2)).y());
  direction = {};
  direction.aside_rad = 0.5;
  const Onlooker left(direction, {points, 0.0, {}}, area);
  // From the left, points behind are to the left of points in front.
  EXPECT_LT(left.to_canvas(Eigen::Vector3d(0, 0, 2)).x(), left.to_canvas(Eigen::Vector3d(0, 0, -2)).x());
}

TEST(Onlooker, OneWildPointDoesNotShrinkTheView) {
  auto points = cube(2.0);
  const Rect area{0, 0, 400, 400};
  const double scale = Onlooker({}, {points, 0.05, {}}, area).pixels_per_metre();
  points.emplace_back(1e6, -1e6, 1e6);
  EXPECT_NEAR(Onlooker({}, {points, 0.05, {}}, area).pixels_per_metre(), scale, 0.35 * scale);
}

TEST(Onlooker, KeepsTheWholeInView) {
  const auto points = cube(1.0);
  const std::vector<Eigen::Vector3d> path{{0, 0, 0}, {30, 0, 0}};
  const Rect area{0, 0, 400, 400};
  const Onlooker onlooker({}, {points, 0.05, path}, area);
  EXPECT_TRUE(area.contains(onlooker.to_canvas(path[1])));
}

TEST(Onlooker, EmptyAndPlainSubjectsAreFine) {
  const Rect area{0, 0, 400, 400};
  EXPECT_TRUE(Onlooker({}, {}, area).to_canvas(Eigen::Vector3d::Zero()).allFinite());
  const std::vector<Eigen::Vector3d> one{{3, 4, 5}};
  EXPECT_TRUE(Onlooker({}, {one, 0.03, {}}, area).to_canvas(one[0]).isApprox(area.center(), 1e-6));
  Onlooker::Direction straight_down;
  straight_down.forward = Eigen::Vector3d::UnitY();
  EXPECT_TRUE(Onlooker(straight_down, {one, 0.03, {}}, area).to_canvas(one[0]).allFinite());
  EXPECT_FALSE(Onlooker({}, {}, area).to_canvas(Eigen::Vector3d(0, 0, -1e3)).allFinite()) << "behind the onlooker";
}

TEST(CameraPyramid, OpensAsTheLensDoes) {
  const std::vector<Line3> edges = camera_pyramid({}, kGeometry, 2.0);
  ASSERT_EQ(edges.size(), 5U);
  EXPECT_TRUE(edges[0][0].isApprox(Eigen::Vector3d(-1.6, -0.8, 2.0)));
  EXPECT_TRUE(edges[1][0].isZero());
  Se3 moved;
  moved.translation = {1.0, 2.0, 3.0};
  EXPECT_TRUE(camera_pyramid(moved, kGeometry, 2.0)[1][0].isApprox(moved.translation));
}

TEST(EveryNth, KeepsAtMostWhatWasAskedFor) {
  EXPECT_EQ(every_nth(0, 10), 1U);
  EXPECT_EQ(every_nth(10, 10), 1U);
  EXPECT_EQ(every_nth(11, 10), 2U);
  EXPECT_EQ(every_nth(100'000, 3000), 34U);
}

TEST(PlanView, IsToScaleAndNeverMirrored) {
  const Rect wide{0, 0, 600, 200};
  for (const auto& [x, z] : {std::pair{drawing::Range{-5, 5}, drawing::Range{0, 60}},
                             std::pair{drawing::Range{-30, 30}, drawing::Range{0, 5}}}) {
    const PlanView plan(wide, x, z);
    const Point origin = plan.to_canvas(Eigen::Vector3d::Zero());
    const Point right = plan.to_canvas(Eigen::Vector3d(1, 0, 0)) - origin;
    const Point forward = plan.to_canvas(Eigen::Vector3d(0, 0, 1)) - origin;
    EXPECT_NEAR(right.norm(), plan.pixels_per_metre(), 1e-9);
    EXPECT_NEAR(forward.norm(), plan.pixels_per_metre(), 1e-9);
    // Canvas y points down: turning right from forward is a positive cross product.
    EXPECT_GT(forward.x() * right.y() - forward.y() * right.x(), 0.0);
    EXPECT_NEAR(plan.pixels_per_metre(), 10.0, 1e-9);
  }
  // Long along z: z lies to the right.
  const PlanView along(wide, {-5, 5}, {0, 60});
  EXPECT_GT(along.to_canvas(Eigen::Vector3d(0, 0, 1)).x(), along.to_canvas(Eigen::Vector3d::Zero()).x());
}

TEST(PlanView, LyingKeepsZToTheRight) {
  const PlanView plan = PlanView::lying({0, 0, 600, 200}, {-30, 30}, {0, 5});
  EXPECT_GT(plan.to_canvas(Eigen::Vector3d(0, 0, 1)).x(), plan.to_canvas(Eigen::Vector3d::Zero()).x());
  EXPECT_NEAR(plan.z_range().size(), 180.0, 1e-9);
}

}  // namespace
}  // namespace kinetrace::figure

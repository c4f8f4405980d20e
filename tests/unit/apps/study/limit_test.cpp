// The limit study: bounds known in closed form, points and noise of a truth written by hand.
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "study/limit_summary.hpp"
#include "study/motion_bound.hpp"
#include "study/pixel_noise.hpp"
#include "study/visible_points.hpp"

namespace kinetrace::app {
namespace {

using ::testing::HasSubstr;

constexpr StereoGeometry kRig{700.0, 700.0, 600.0, 180.0, 0.5, 1200, 360};
constexpr PixelNoise kNoise{0.1, 0.2};
// Practically no prior.
constexpr MotionPrior kNoPrior{1e9, 1e9, 1e9, 1e9, 1e9};
constexpr double kDepth_m = 20.0;
constexpr double kHalf_m = 0.5;

/// Four points on the corners of a square that faces the camera; at rest.
SeenBody square(std::size_t views) {
  SeenBody body;
  std::vector<std::size_t> all;
  for (std::size_t k = 0; k < views; ++k) {
    const Se3 pose{Eigen::Matrix3d::Identity(), {0.0, 0.0, kDepth_m}};
    body.views.push_back({static_cast<std::int64_t>(k), static_cast<std::int64_t>(k) * 100'000'000, pose, pose, 4});
    all.push_back(k);
  }
  for (const double x : {-kHalf_m, kHalf_m}) {
    for (const double y : {-kHalf_m, kHalf_m}) {
      body.points.push_back({{x, y, 0.0}, all});
    }
  }
  return body;
}

// Two views of unknown points give the motion by the difference of two means. Sideways: of image positions. Along the
// axis: of disparities, and of the square's size in the image, measured by eight coordinates that move by f a / Z^2
// each. About the axis, points move by their distance a sqrt(2) from it; about the other axes, they approach and recede
// by a each, measured by disparities and by the edges' inclination f a^2 / Z^2.
TEST(PoseBound, OfTwoViewsIsKnownInClosedForm) {
  const std::vector<PoseBound> bounds = pose_bounds(square(2), kRig, kNoise, kNoPrior);
  ASSERT_EQ(bounds.size(), 2U);
  const double metre_px = kRig.fx_px / kDepth_m;
  const double disparity_px = kRig.fx_px * kRig.baseline_m / (kDepth_m * kDepth_m);
  const double growth_px = kRig.fx_px * kHalf_m / (kDepth_m * kDepth_m);
  const double sideways_m2 = 2.0 * std::pow(kNoise.position_px / metre_px, 2) / 4.0;
  const double along_m2 =
      2.0 / (4.0 * std::pow(disparity_px / kNoise.disparity_px, 2) + 8.0 * std::pow(growth_px / kNoise.position_px, 2));
  EXPECT_NEAR(bounds[1].motion_m, std::sqrt(2.0 * sideways_m2 + along_m2), 0.03 * bounds[1].motion_m);
  const double about_axis = 2.0 / (8.0 * std::pow(metre_px * kHalf_m / kNoise.position_px, 2));
  const double keystone_px = kRig.fx_px * kHalf_m * kHalf_m / (kDepth_m * kDepth_m);
  const double about_others = 2.0 / (4.0 * std::pow(disparity_px * kHalf_m / kNoise.disparity_px, 2) +
                                     4.0 * std::pow(keystone_px / kNoise.position_px, 2));
  EXPECT_NEAR(bounds[1].motion_deg, std::sqrt(about_axis + 2.0 * about_others) * 180.0 / std::numbers::pi,
              0.03 * bounds[1].motion_deg);
  // The common offset that fits both leaves half of the motion in each.
  EXPECT_NEAR(bounds[0].place_m, 0.5 * bounds[1].motion_m, 1e-9);
  EXPECT_NEAR(bounds[1].place_m, 0.5 * bounds[1].motion_m, 1e-9);
  EXPECT_EQ(bounds[0].motion_m, 0.0);
}

TEST(PoseBound, GrowsWithTheNoiseAndShrinksWithThePoints) {
  SeenBody body = square(2);
  const double once = pose_bounds(body, kRig, kNoise, kNoPrior)[1].motion_m;
  EXPECT_NEAR(pose_bounds(body, kRig, {0.2, 0.4}, kNoPrior)[1].motion_m, 2.0 * once, 1e-3 * once);
  const std::vector<SeenBody::Point> points = body.points;
  for (int copy = 0; copy < 3; ++copy) {
    body.points.insert(body.points.end(), points.begin(), points.end());
  }
  EXPECT_NEAR(pose_bounds(body, kRig, kNoise, kNoPrior)[1].motion_m, 0.5 * once, 1e-3 * once);
}

// A steady motion: the bound of n views decreases like that of a straight line's slope.
TEST(PoseBound, OfASteadyMotionIsThatOfALine) {
  constexpr std::size_t kViews = 10;
  const std::vector<PoseBound> free = pose_bounds(square(kViews), kRig, kNoise, kNoPrior);
  const std::vector<PoseBound> steady = pose_bounds(square(kViews), kRig, kNoise, {1e-6, 1e-6, 1e-6, 1e-6});
  // Variance of a slope over n equal steps: 12 s^2 / (n (n^2 - 1)); of one difference: 2 s^2.
  const double expected = std::sqrt(12.0 / (kViews * (kViews * kViews - 1.0)) / 2.0);
  for (const std::size_t k : {1U, 5U, 9U}) {
    EXPECT_NEAR(steady[k].motion_m / free[k].motion_m, expected, 0.04 * expected) << k;
  }
}

TEST(PoseBound, OfOneViewIsNone) {
  const std::vector<PoseBound> bounds = pose_bounds(square(1), kRig, kNoise, {});
  ASSERT_EQ(bounds.size(), 1U);
  EXPECT_EQ(bounds[0].motion_m, 0.0);
  EXPECT_TRUE(pose_bounds({}, kRig, kNoise, {}).empty());
}

/// Truth of a wall 20 m away, one object that fills the image from the column `from_px` on.
class WallTruth {
 public:
  explicit WallTruth(int from_px) : labels_(static_cast<std::size_t>(kRig.width_px * kRig.height_px), 0) {
    for (int y = 0; y < kRig.height_px; ++y) {
      for (int x = from_px; x < kRig.width_px; ++x) {
        labels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(kRig.width_px) + static_cast<std::size_t>(x)] =
            1;
      }
    }
    images_.masks = {labels_, kRig.width_px, kRig.height_px, {{1, 1001, 1}}};
    images_.depth = {depths_.data(), kRig.width_px, kRig.height_px, kRig.width_px};
  }
  const TrueImages& images() const { return images_; }
  static std::vector<evaluation::LocatedObject> objects() {
    evaluation::LocatedObject wall;
    wall.object.id = 1;
    wall.object.T_world_obj = {Eigen::Matrix3d::Identity(), {0.0, 0.0, kDepth_m}};
    wall.center_m = {0.0, 0.0, kDepth_m};
    return {wall};
  }

 private:
  std::vector<std::uint8_t> labels_;
  std::vector<std::uint16_t> depths_ =
      std::vector<std::uint16_t>(labels_.size(), static_cast<std::uint16_t>(256.0 * kDepth_m));
  TrueImages images_;
};

TEST(VisiblePoints, StandInEveryCellAndEndWhereTheyAreHidden) {
  VisiblePoints visible(kRig);
  visible.add(0, 0, {}, WallTruth::objects(), WallTruth(0).images());
  visible.add(1, 100, {}, WallTruth::objects(), WallTruth(600).images());
  visible.add(2, 200, {}, WallTruth::objects(), WallTruth(0).images());
  const SeenBody& wall = visible.bodies().at(1);
  ASSERT_EQ(wall.views.size(), 3U);
  const std::size_t all = std::size_t{75} * 33;  // 1200 x 360 in cells of 16 x 11.
  EXPECT_EQ(wall.views[0].points, all);
  EXPECT_NEAR(static_cast<double>(wall.views[1].points), 0.5 * static_cast<double>(all), 34.0);
  EXPECT_EQ(wall.views[2].points, all) << "new ones where the old ones have ended";
  EXPECT_NEAR(static_cast<double>(wall.points.size()), 1.5 * static_cast<double>(all), 34.0);
  for (const SeenBody::Point& point : wall.points) {
    EXPECT_NEAR(point.position_m.z(), 0.0, 1e-9);
  }
}

TEST(PixelNoise, IsFoundAgainInObservations) {
  const WallTruth truth(0);
  PixelNoiseMeter meter(kRig);
  EXPECT_FALSE(meter.noise());
  std::mt19937 random(1);
  std::normal_distribution<float> place(0.F, 0.1F);
  std::normal_distribution<float> disparity(0.F, 0.2F);
  for (int frame = 0; frame < 20; ++frame) {
    std::vector<PointObservation> observations;
    for (std::uint32_t id = 0; id < 100; ++id) {
      const float u = 50.F + 11.F * static_cast<float>(id) + place(random);
      const auto wide = static_cast<float>(kRig.disparity_px(kDepth_m));
      observations.push_back({id, u, 100.F + place(random), u - wide + (id == 7 ? 90.F : disparity(random))});
    }
    std::vector<BodyGeometry> bodies(1);
    bodies[0].track_id = 5;
    bodies[0].observations = observations;
    FrameResult result;
    result.newest.frame_index = frame;
    result.bodies = bodies;
    meter.add(result, {}, WallTruth::objects(), truth.images());
  }
  ASSERT_TRUE(meter.noise());
  EXPECT_NEAR(meter.noise()->position_px, 0.1, 0.005);
  EXPECT_NEAR(meter.noise()->disparity_px, 0.2, 0.01) << "the wrong match does not count";
}

std::vector<LimitRun> three_frames() {
  LimitRun run{"one", kNoise, {}};
  for (int i = 0; i < 3; ++i) {
    LimitRow row;
    row.run = {.frame = i, .object_id = 1, .distance_m = 12.0};
    row.run.published_motion_m = i == 2 ? std::nullopt : std::optional(0.02 * (i + 1));
    row.bound.motion_m = 0.01;
    row.points = 8;
    run.rows.push_back(row);
  }
  return {run};
}

TEST(LimitSummary, DividesEachErrorByItsBound) {
  const std::vector<LimitRun> runs = three_frames();
  const LimitBin bin = limit_bin(runs, kLimitMetrics[1], 1);
  EXPECT_EQ(bin.frames, 3U);
  EXPECT_NEAR(*bin.mean_ratio(), 3.0, 1e-12);
  EXPECT_NEAR(*bin.median_ratio(), 4.0, 1e-12);
  EXPECT_FALSE(limit_bin(runs, kLimitMetrics[1], 2).mean_ratio());
  EXPECT_EQ(limit_bin(runs, kLimitMetrics[0], 1).frames, 0U) << "no bound, no ratio";
  EXPECT_THAT(limit_tables(runs),
              HasSubstr("motion [m]\n  distance    frames  measured     error     bound     ratio"));
  EXPECT_THAT(limit_tables(runs),
              HasSubstr("  10 - 20 m         3         2    0.0300    0.0100      3.00      4.00\n"));
}

TEST(LimitSummary, WritesATableAndAChart) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "limit_summary";
  std::filesystem::create_directories(folder);
  ASSERT_TRUE(write_limit_csv(three_frames(), folder));
  ASSERT_TRUE(write_limit_plot(three_frames(), folder));
  EXPECT_TRUE(check_limit_places(folder)) << "another study may replace them";
  EXPECT_GT(std::filesystem::file_size(folder / "limit.csv"), 100U);
  EXPECT_GT(std::filesystem::file_size(folder / "limit.png"), 5000U);
  EXPECT_EQ(write_limit_csv({}, folder / "missing").error().code, ErrorCode::kIo);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace kinetrace::app

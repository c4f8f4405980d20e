#include "rig_bundle.hpp"

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "outlier_rounds.hpp"
#include "scene_evidence.hpp"
#include "synthetic_drive.hpp"
#include "uncertainty.hpp"
#include "verdict.hpp"
#include "window_start.hpp"

namespace kinetrace::self_calibration {
namespace {

using test::distorted_rig;
using test::DriveOptions;
using test::Motion;
using test::synthetic_drive;
using test::World;
using ::testing::HasSubstr;

struct Fit {
  RigModel rig;
  std::vector<BundleWindow> windows;
  BundleOptions options;
};

std::vector<BundleWindow> started(const RigModel& rig, const std::vector<TrackWindow>& tracks) {
  std::vector<BundleWindow> windows;
  for (const TrackWindow& window : tracks) {
    if (std::optional<BundleWindow> start = start_window(rig, window)) {
      windows.push_back(std::move(*start));
    }
  }
  return windows;
}

Fit fit(const RigModel& start, const std::vector<TrackWindow>& tracks) {
  Fit result{start, started(start, tracks), {}};
  result.options.sigma_px = 0.5;
  EXPECT_TRUE(adjust_in_rounds(result.rig, result.windows, RoundPlan::kFromAfar, result.options));
  result.windows = started(result.rig, tracks);
  EXPECT_TRUE(adjust_in_rounds(result.rig, result.windows, RoundPlan::kFromNear, result.options));
  return result;
}

/// Straight lenses, a focal length that is five per cent off, views in parallel.
RigModel poor_start() {
  RigModel rig = plain_rig({640, 480}, 0.3, 440.0);
  for (LensBlock& lens : rig.lens) {
    lens[kK1] = -0.1;
  }
  rig.mount = {0.0, -0.015, -0.013, 0.0, 0.0};
  return rig;
}

TEST(RigBundle, FindsLensesAndMountToTheirSigma) {
  RigModel truth = distorted_rig();
  Fit found = fit(poor_start(), synthetic_drive(truth, {}));
  const RigCovariance covariance = rig_covariance(found.rig, found.windows, found.options);
  EXPECT_NEAR(found.options.sigma_px, 0.05, 0.01);
  EXPECT_NEAR(found.rig.focal_px(0), truth.focal_px(0), 0.005 * truth.focal_px(0));
  for (int i = 0; i < kRigSize; ++i) {
    const double error = found.rig.parameter(i) - truth.parameter(i);
    EXPECT_LT(std::abs(error), 4.0 * std::sqrt(covariance(i, i))) << "parameter " << i;
  }
}

TEST(RigBundle, LeavesOutWhatMovesByItself) {
  RigModel truth = distorted_rig();
  DriveOptions options;
  options.outlier_share = 0.15;
  const Fit found = fit(poor_start(), synthetic_drive(truth, options));
  EXPECT_NEAR(found.options.sigma_px, 0.05, 0.01);
  EXPECT_NEAR(found.rig.focal_px(0), truth.focal_px(0), 0.005 * truth.focal_px(0));
  EXPECT_LT(used_share(found.windows), 0.95);
  EXPECT_GT(used_share(found.windows), 0.7);
}

TEST(RigBundle, DoesNotMoveARigThatIsHeld) {
  const RigModel truth = distorted_rig();
  RigModel rig = truth;
  std::vector<BundleWindow> windows = started(rig, synthetic_drive(truth, {}));
  BundleOptions options;
  options.rig_fixed = true;
  ASSERT_TRUE(adjust(rig, windows, options));
  EXPECT_EQ(rig.lens, truth.lens);
  EXPECT_EQ(rig.mount, truth.mount);
}

TEST(RigBundle, IsTheSameEveryTime) {
  const std::vector<TrackWindow> tracks = synthetic_drive(distorted_rig(), {.windows = 2, .points = 60});
  const Fit first = fit(poor_start(), tracks);
  const Fit second = fit(poor_start(), tracks);
  EXPECT_EQ(first.rig.lens, second.rig.lens);
  EXPECT_EQ(first.rig.mount, second.rig.mount);
}

TEST(WindowStart, IsEmptyWhereTooLittleIsSeen) {
  const RigModel truth = distorted_rig();
  const std::vector<TrackWindow> tracks = synthetic_drive(truth, {.windows = 1, .points = 8});
  EXPECT_FALSE(start_window(truth, tracks[0]));
}

Findings findings(const Fit& found) {
  const RigCovariance covariance = rig_covariance(found.rig, found.windows, found.options);
  return {found.windows.size(),    used_share(found.windows),
          found.options.sigma_px,  scene_evidence(found.rig, found.windows),
          focal_sigma(covariance), depth_sigma(found.rig, covariance, 50.0 * found.rig.baseline_m)};
}

TEST(SceneEvidence, OfADriveIsAccepted) {
  const Findings seen = findings(fit(poor_start(), synthetic_drive(distorted_rig(), {})));
  EXPECT_GT(seen.scene.parallax_px, 10.0);
  EXPECT_GT(seen.scene.depth_ratio, 3.0);
  EXPECT_LT(seen.scene.plane_share, 0.6);
  EXPECT_TRUE(verdict(seen)) << verdict(seen).error().message;
}

TEST(SceneEvidence, OfATurnInPlaceIsRefused) {
  const Findings seen = findings(fit(poor_start(), synthetic_drive(distorted_rig(), {.motion = Motion::kTurn})));
  EXPECT_GT(seen.scene.travel_px, 10.0);
  EXPECT_LT(seen.scene.parallax_px, 4.0);
  ASSERT_FALSE(verdict(seen));
  EXPECT_THAT(verdict(seen).error().message, HasSubstr("turns but does not travel"));
}

TEST(SceneEvidence, OfACameraAtRestIsRefused) {
  const Findings seen = findings(fit(distorted_rig(), synthetic_drive(distorted_rig(), {.motion = Motion::kRest})));
  ASSERT_FALSE(verdict(seen));
  EXPECT_THAT(verdict(seen).error().message, HasSubstr("at rest"));
}

TEST(SceneEvidence, OfAWallIsRefused) {
  const Findings seen = findings(fit(distorted_rig(), synthetic_drive(distorted_rig(), {.world = World::kWall})));
  EXPECT_GT(seen.scene.plane_share, 0.95);
  ASSERT_FALSE(verdict(seen));
  EXPECT_THAT(verdict(seen).error().message, HasSubstr("one plane"));
}

}  // namespace
}  // namespace kinetrace::self_calibration

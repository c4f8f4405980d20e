// The online solver and Ceres reach the same optimum of the same problem.
#include <ostream>

#include <gtest/gtest.h>

#include "bundle_scene.hpp"
#include "fixed_solver.hpp"

namespace kinetrace::refinement {
namespace {

struct Case {
  const char* name;
  SceneOptions options;
};
void PrintTo(const Case& c, std::ostream* out) {  // NOLINT(readability-identifier-naming): GoogleTest's name
  *out << c.name;
}

SceneOptions with(void (*change)(SceneOptions&)) {
  SceneOptions options;
  options.points = 200;
  change(options);
  return options;
}

class BundleAgreement : public testing::TestWithParam<Case> {};

TEST_P(BundleAgreement, BothSolversReachTheSameOptimum) {
  BundleScene ours = make_scene(GetParam().options);
  BundleScene theirs = ours;
  FixedSolver fixed(patient_config());
  CeresBundleAdjuster ceres = patient_ceres();
  BundleWindow our_window = ours.window();
  BundleWindow their_window = theirs.window();
  const Result<BundleSummary> our_summary = fixed.adjuster.refine(our_window);
  const Result<BundleSummary> their_summary = ceres.refine(their_window);
  ASSERT_TRUE(our_summary) << our_summary.error().message;
  ASSERT_TRUE(their_summary) << their_summary.error().message;

  EXPECT_NEAR(our_summary->initial_cost / their_summary->initial_cost, 1.0, 1e-5);
  EXPECT_NEAR(our_summary->final_cost / their_summary->final_cost, 1.0, 1e-4);
  EXPECT_LT(our_summary->final_cost, 0.5 * our_summary->initial_cost);
  const PoseDifference d = largest_difference(ours.T_body_cam, theirs.T_body_cam);
  EXPECT_LT(d.position_m, 1e-4);
  EXPECT_LT(d.angle_rad, 1e-5);
  const Matrix6d& a = our_summary->newest_covariance;
  const Matrix6d& b = their_summary->newest_covariance;
  EXPECT_LE((a - b).norm(), 0.02 * b.norm());
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, BundleAgreement,
    testing::Values(
        Case{"plain", with([](SceneOptions&) {})},
        Case{"six_frames_sixty_points", with([](SceneOptions& o) { o.frames = 6, o.points = 60; })},
        Case{"long_tracks", with([](SceneOptions& o) { o.track_frames = 10; })},
        Case{"mono_and_stereo", with([](SceneOptions& o) { o.mono_ratio = 0.4; })},
        Case{"expected_turns", with([](SceneOptions& o) { o.turn_sigma_rad = 1e-4, o.unexpected_turn_rad = 2e-5; })},
        Case{"unexpected_turns", with([](SceneOptions& o) { o.turn_sigma_rad = 1e-4, o.unexpected_turn_rad = 2e-3; })},
        Case{"outliers", with([](SceneOptions& o) { o.outlier_ratio = 0.1; })},
        Case{"far", with([](SceneOptions& o) { o.min_depth_m = 30.0, o.max_depth_m = 120.0; })},
        Case{"two_fixed", with([](SceneOptions& o) { o.fixed_frames = 0b11; })},
        Case{"middle_fixed", with([](SceneOptions& o) { o.fixed_frames = 0b10000; })},
        Case{"newest_fixed", with([](SceneOptions& o) { o.fixed_frames = 0b1000000000; })},
        Case{"small_baseline", with([](SceneOptions& o) { o.baseline_m = 0.11, o.max_depth_m = 12.0; })},
        Case{"far_origin", with([](SceneOptions& o) {
               o.T_body_start = {so3_exp({0.3, -1.0, 2.0}), {7000.0, -300.0, 7000.0}};
             })}),
    [](const testing::TestParamInfo<Case>& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace kinetrace::refinement

#include "kinetrace/refinement/fixed_bundle_adjuster.hpp"

#include <cstring>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bundle_scene.hpp"
#include "fixed_solver.hpp"
#include "kinetrace/core/allocation_counter.hpp"

namespace kinetrace::refinement {
namespace {

bool same_bits(const std::vector<Se3>& a, const std::vector<Se3>& b) {
  return std::memcmp(a.data(), b.data(), a.size() * sizeof(Se3)) == 0;
}
bool same_points(const std::vector<BundlePoint>& a, const std::vector<BundlePoint>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].position_m != b[i].position_m) {
      return false;
    }
  }
  return true;
}
bool all_finite(const BundleScene& scene) {
  return std::all_of(scene.T_body_cam.begin(), scene.T_body_cam.end(), [](const Se3& p) { return p.is_finite(); }) &&
         std::all_of(scene.points.begin(), scene.points.end(),
                     [](const BundlePoint& p) { return p.position_m.allFinite(); });
}

TEST(FixedBundleConfig, NamesTheKeyThatIsOutOfRange) {
  const auto message = [](void (*change)(FixedBundleConfig&)) {
    FixedBundleConfig config;
    change(config);
    const Status status = config.validate();
    return status ? std::string() : status.error().message;
  };
  EXPECT_EQ(message([](FixedBundleConfig&) {}), "");
  EXPECT_THAT(message([](FixedBundleConfig& c) { c.max_frames = 33; }), testing::HasSubstr("refinement.max_frames"));
  EXPECT_THAT(message([](FixedBundleConfig& c) { c.max_frames = 1; }), testing::HasSubstr("got 1"));
  EXPECT_THAT(message([](FixedBundleConfig& c) { c.max_points = 0; }), testing::HasSubstr("refinement.max_points"));
  EXPECT_THAT(message([](FixedBundleConfig& c) { c.max_iterations = 0; }), testing::HasSubstr("max_iterations"));
  EXPECT_THAT(message([](FixedBundleConfig& c) { c.robust_threshold_sigmas = std::nan(""); }),
              testing::HasSubstr("robust_threshold_sigmas"));
  EXPECT_THAT(message([](FixedBundleConfig& c) { c.initial_damping = -1.0; }), testing::HasSubstr("initial_damping"));
  EXPECT_THAT(message([](FixedBundleConfig& c) { c.relative_cost_tolerance = 1.0; }),
              testing::HasSubstr("relative_cost_tolerance"));
}

TEST(FixedBundleAdjuster, TakesExactlyTheBytesItAsksFor) {
  const FixedBundleConfig config;
  const std::size_t bytes = FixedBundleAdjuster::required_bytes(config);
  Arena enough(bytes);
  EXPECT_TRUE(FixedBundleAdjuster::create(config, enough));
  EXPECT_EQ(enough.used_bytes(), bytes);
  Arena too_small(bytes - 1);
  const auto refused = FixedBundleAdjuster::create(config, too_small);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kCapacity);
}

TEST(FixedBundleAdjuster, FindsTheTruthWithoutNoise) {
  SceneOptions options;
  options.noise_px = 0.0;
  options.points = 100;
  BundleScene scene = make_scene(options);
  FixedSolver solver(patient_config());
  BundleWindow window = scene.window();
  const auto summary = solver.adjuster.refine(window);
  ASSERT_TRUE(summary);
  const PoseDifference d = largest_difference(scene.T_body_cam, scene.true_T_body_cam);
  EXPECT_LT(d.position_m, 1e-4);
  EXPECT_LT(d.angle_rad, 1e-5);
  for (std::size_t p = 0; p < scene.points.size(); ++p) {
    EXPECT_LT((scene.points[p].position_m - scene.true_points_m[p]).norm(), 0.01);
  }
}

TEST(FixedBundleAdjuster, DefaultSettingsImproveANoisyWindow) {
  BundleScene scene = make_scene({});
  const PoseDifference before = largest_difference(scene.T_body_cam, scene.true_T_body_cam);
  FixedSolver solver({});
  BundleWindow window = scene.window();
  const auto summary = solver.adjuster.refine(window);
  ASSERT_TRUE(summary);
  const PoseDifference after = largest_difference(scene.T_body_cam, scene.true_T_body_cam);
  EXPECT_LT(after.position_m, 0.2 * before.position_m);
  EXPECT_LT(after.angle_rad, 0.2 * before.angle_rad);
  EXPECT_LE(summary->iterations, 6);
  // 2500 observations x 3 rows - 500 points x 3 - 9 poses x 6 degrees of freedom, half a sigma^2 each; the robust loss
  // gives a little less.
  const double chance = 0.5 * (7500 - 1500 - 54);
  EXPECT_LT(summary->final_cost, chance);
  EXPECT_GT(summary->final_cost, 0.65 * chance);
}

TEST(FixedBundleAdjuster, TransformingTheWorldChangesNothing) {
  const Se3 T_far_body{so3_exp({0.4, 2.0, -1.0}), {-9000.0, 120.0, 4000.0}};
  SceneOptions options;
  options.points = 150;
  BundleScene here = make_scene(options);
  BundleScene there = here;
  for (Se3& pose : there.T_body_cam) {
    pose = T_far_body * pose;
  }
  for (BundlePoint& point : there.points) {
    point.position_m = T_far_body * point.position_m;
  }
  FixedSolver solver(patient_config());
  BundleWindow window_here = here.window();
  BundleWindow window_there = there.window();
  const auto summary_here = solver.adjuster.refine(window_here);
  const auto summary_there = solver.adjuster.refine(window_there);
  ASSERT_TRUE(summary_here && summary_there);
  EXPECT_NEAR(summary_here->initial_cost / summary_there->initial_cost, 1.0, 1e-6);
  EXPECT_NEAR(summary_here->final_cost / summary_there->final_cost, 1.0, 1e-6);
  for (std::size_t k = 0; k < here.T_body_cam.size(); ++k) {
    const PoseDifference d = difference(T_far_body * here.T_body_cam[k], there.T_body_cam[k]);
    EXPECT_LT(d.position_m, 2e-5);
    EXPECT_LT(d.angle_rad, 2e-6);
  }
  const Matrix6d carry = adjoint(T_far_body);
  const Matrix6d expected = carry * summary_here->newest_covariance * carry.transpose();
  EXPECT_LT((summary_there->newest_covariance - expected).norm(), 1e-2 * expected.norm());
}

TEST(FixedBundleAdjuster, TwentyPercentOutliersDoNotHurt) {
  SceneOptions options;
  options.points = 300;
  options.outlier_ratio = 0.2;
  BundleScene scene = make_scene(options);
  FixedSolver solver(patient_config());
  BundleWindow window = scene.window();
  ASSERT_TRUE(solver.adjuster.refine(window));
  const PoseDifference d = largest_difference(scene.T_body_cam, scene.true_T_body_cam);
  EXPECT_LT(d.position_m, 0.02);
  EXPECT_LT(d.angle_rad, 1e-3);
}

TEST(FixedBundleAdjuster, PureMonoWindowKeepsFinite) {
  SceneOptions options;
  options.mono_ratio = 1.0;
  options.points = 80;
  BundleScene scene = make_scene(options);
  FixedSolver solver(patient_config());
  BundleWindow window = scene.window();
  const auto summary = solver.adjuster.refine(window);
  ASSERT_TRUE(summary);
  EXPECT_TRUE(all_finite(scene));
  EXPECT_TRUE(summary->newest_covariance.allFinite());
  EXPECT_LT(summary->final_cost, 0.1 * summary->initial_cost);
}

TEST(FixedBundleAdjuster, PointsWithASingleMonoObservationStayFiniteAndDoNotMovePoses) {
  SceneOptions options;
  options.points = 60;
  BundleScene clean = make_scene(options);
  BundleScene extended = clean;
  for (int i = 0; i < 9; ++i) {
    BundlePoint lonely = clean.points[static_cast<std::size_t>(i)];
    lonely.frames = 1U << 4U;
    extended.points.push_back(lonely);
    std::vector<BundleObservation> row(clean.T_body_cam.size());
    row[4].u_left_px = 300.F + 40.F * static_cast<float>(i);
    row[4].v_px = 180.F;
    row[4].inverse_sigma_px = 3.F;
    extended.observations.insert(extended.observations.end(), row.begin(), row.end());
  }
  FixedSolver solver(patient_config());
  BundleWindow clean_window = clean.window();
  BundleWindow extended_window = extended.window();
  ASSERT_TRUE(solver.adjuster.refine(clean_window));
  const auto summary = solver.adjuster.refine(extended_window);
  ASSERT_TRUE(summary);
  EXPECT_TRUE(all_finite(extended));
  EXPECT_TRUE(summary->newest_covariance.allFinite());
  const PoseDifference d = largest_difference(clean.T_body_cam, extended.T_body_cam);
  EXPECT_LT(d.position_m, 1e-3);
  EXPECT_LT(d.angle_rad, 1e-4);
}

TEST(FixedBundleAdjuster, PointsAtHugeDepthStayFiniteAndSteadyTheRotation) {
  SceneOptions options;
  options.points = 60;
  BundleScene scene = make_scene(options);
  for (std::size_t p = 0; p < 20; ++p) {
    // As seen by every frame at infinity: no disparity, some noise on the depth.
    const Eigen::Vector3d direction = Eigen::Vector3d(0.05 * static_cast<double>(p) - 0.5, 0.1, 1.0);
    const double distance_m = p % 3 == 0 ? 1e30 : (p % 3 == 1 ? 1e6 : 3e3);
    scene.points[p].position_m = direction * distance_m;
    scene.points[p].frames = 0;
    for (std::size_t k = 0; k < scene.T_body_cam.size(); ++k) {
      const Eigen::Vector3d seen =
          scene.geometry.project(scene.true_T_body_cam[k].rotation.transpose() * direction * 1e9);
      BundleObservation& o = scene.observation(p, k);
      o.u_left_px = static_cast<float>(seen[0]);
      o.v_px = static_cast<float>(seen[1]);
      o.u_right_px = static_cast<float>(seen[0] + (k % 2 == 0 ? 0.2 : -0.2));
      o.inverse_sigma_px = 3.F;
      scene.points[p].frames |= 1U << k;
    }
  }
  BundleScene near_only = scene;
  for (std::size_t p = 0; p < 20; ++p) {
    near_only.points[p].frames = 0;
  }
  FixedSolver solver(patient_config());
  BundleWindow window = scene.window();
  BundleWindow near_window = near_only.window();
  const auto summary = solver.adjuster.refine(window);
  ASSERT_TRUE(summary);
  ASSERT_TRUE(solver.adjuster.refine(near_window));
  EXPECT_TRUE(all_finite(scene));
  EXPECT_TRUE(summary->newest_covariance.allFinite());
  const double angle_rad = largest_difference(scene.T_body_cam, scene.true_T_body_cam).angle_rad;
  const double near_only_rad = largest_difference(near_only.T_body_cam, near_only.true_T_body_cam).angle_rad;
  EXPECT_LT(angle_rad, 0.8 * near_only_rad);
}

TEST(FixedBundleAdjuster, PointBehindTheCameraDoesNotSpoilTheOthers) {
  SceneOptions options;
  options.points = 100;
  BundleScene scene = make_scene(options);
  scene.points[7].position_m = Eigen::Vector3d(0.0, 0.0, -5.0);
  scene.points[8].position_m = Eigen::Vector3d::Zero();
  FixedSolver solver(patient_config());
  BundleWindow window = scene.window();
  ASSERT_TRUE(solver.adjuster.refine(window));
  EXPECT_TRUE(all_finite(scene));
  const PoseDifference d = largest_difference(scene.T_body_cam, scene.true_T_body_cam);
  EXPECT_LT(d.position_m, 0.05);
}

TEST(FixedBundleAdjuster, UnobservedPoseStaysAndGetsALargeCovariance) {
  BundleScene scene = make_scene({});
  for (BundlePoint& point : scene.points) {
    point.frames &= ~(1U << 9U);
  }
  const Se3 before = scene.T_body_cam[9];
  FixedSolver solver({});
  BundleWindow window = scene.window();
  const auto summary = solver.adjuster.refine(window);
  ASSERT_TRUE(summary);
  EXPECT_LT(difference(before, scene.T_body_cam[9]).position_m, 1e-9);
  EXPECT_TRUE(summary->newest_covariance.allFinite());
  EXPECT_GT(summary->newest_covariance.diagonal().minCoeff(), 1e3);
}

TEST(FixedBundleAdjuster, LeavesWindowsWithoutFreeParametersAlone) {
  BundleScene scene = make_scene({});
  scene.fixed_frames = ~0U;
  const BundleScene before = scene;
  FixedSolver solver({});
  BundleWindow all_fixed = scene.window();
  const auto fixed = solver.adjuster.refine(all_fixed);
  ASSERT_TRUE(fixed);
  EXPECT_TRUE(fixed->converged);
  EXPECT_EQ(fixed->iterations, 0);
  EXPECT_TRUE(fixed->newest_covariance.isZero());

  scene.fixed_frames = 1U;
  for (BundlePoint& point : scene.points) {
    point.frames = 0;
  }
  BundleWindow unseen = scene.window();
  const auto nothing = solver.adjuster.refine(unseen);
  ASSERT_TRUE(nothing);
  EXPECT_EQ(nothing->iterations, 0);
  EXPECT_TRUE(same_bits(scene.T_body_cam, before.T_body_cam));
  EXPECT_TRUE(same_points(scene.points, before.points));

  BundleWindow empty;
  EXPECT_TRUE(solver.adjuster.refine(empty));
}

TEST(FixedBundleAdjuster, FixedPosesAndUnseenPointsKeepTheirBits) {
  SceneOptions options;
  options.fixed_frames = 0b101;
  BundleScene scene = make_scene(options);
  scene.points[3].frames = 0;
  scene.points[3].position_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  const BundleScene before = scene;
  FixedSolver solver({});
  BundleWindow window = scene.window();
  ASSERT_TRUE(solver.adjuster.refine(window));
  EXPECT_EQ(scene.T_body_cam[0].rotation, before.T_body_cam[0].rotation);
  EXPECT_EQ(scene.T_body_cam[2].translation, before.T_body_cam[2].translation);
  EXPECT_NE(scene.T_body_cam[1].translation, before.T_body_cam[1].translation);
  EXPECT_TRUE(scene.points[3].position_m.hasNaN());
}

TEST(FixedBundleAdjuster, AcceptsItsCapacityAndRefusesOneMore) {
  FixedBundleConfig config;
  config.max_frames = 6;
  config.max_points = 60;
  FixedSolver solver(config);
  SceneOptions options;
  options.frames = 6;
  options.points = 60;
  BundleScene full = make_scene(options);
  BundleWindow full_window = full.window();
  EXPECT_TRUE(solver.adjuster.refine(full_window));

  options.points = 61;
  BundleScene too_many_points = make_scene(options);
  const BundleScene before = too_many_points;
  BundleWindow points_window = too_many_points.window();
  const auto points = solver.adjuster.refine(points_window);
  ASSERT_FALSE(points);
  EXPECT_EQ(points.error().code, ErrorCode::kCapacity);
  EXPECT_THAT(points.error().message, testing::HasSubstr("refinement.max_points = 60"));
  EXPECT_TRUE(same_bits(too_many_points.T_body_cam, before.T_body_cam));

  too_many_points.points[0].frames = 0;
  EXPECT_TRUE(solver.adjuster.refine(points_window)) << "points that nobody sees do not count";

  options.frames = 7;
  options.points = 10;
  BundleScene too_many_frames = make_scene(options);
  BundleWindow frames_window = too_many_frames.window();
  const auto frames = solver.adjuster.refine(frames_window);
  ASSERT_FALSE(frames);
  EXPECT_EQ(frames.error().code, ErrorCode::kCapacity);
}

TEST(FixedBundleAdjuster, RunsTheLargestWindow) {
  FixedBundleConfig config;
  config.max_frames = kMaxWindowFrames;
  FixedSolver solver(config);
  SceneOptions options;
  options.frames = kMaxWindowFrames;
  options.points = 600;
  options.pose_error_m = 0.02;
  BundleScene scene = make_scene(options);
  BundleWindow window = scene.window();
  const auto summary = solver.adjuster.refine(window);
  ASSERT_TRUE(summary);
  EXPECT_LT(summary->final_cost, 0.15 * summary->initial_cost);
}

TEST(FixedBundleAdjuster, RejectsBadWindowsAndLeavesThemUnchanged) {
  FixedSolver solver({});
  const auto refused = [&solver](void (*spoil)(BundleScene&)) {
    SceneOptions options;
    options.points = 20;
    BundleScene scene = make_scene(options);
    spoil(scene);
    const std::vector<Se3> before = scene.T_body_cam;
    BundleWindow window = scene.window();
    const auto result = solver.adjuster.refine(window);
    EXPECT_TRUE(result || same_bits(before, scene.T_body_cam));
    return result ? std::string("accepted") : std::string(to_string(result.error().code));
  };
  EXPECT_EQ(refused([](BundleScene&) {}), "accepted");
  EXPECT_EQ(refused([](BundleScene& s) { s.fixed_frames = 0; }), "invalid_argument");
  EXPECT_EQ(refused([](BundleScene& s) { s.fixed_frames = 1U << 20U; }), "invalid_argument");
  EXPECT_EQ(refused([](BundleScene& s) { s.observations.pop_back(); }), "invalid_argument");
  EXPECT_EQ(refused([](BundleScene& s) { s.T_body_cam[3].translation.x() = std::nan(""); }), "invalid_argument");
  EXPECT_EQ(refused([](BundleScene& s) { s.points[3].position_m.z() = std::nan(""); }), "invalid_argument");
  EXPECT_EQ(refused([](BundleScene& s) { s.turns.resize(3); }), "invalid_argument");
  EXPECT_EQ(refused([](BundleScene& s) {
              s.turns.resize(s.T_body_cam.size());
              s.turns[2].inverse_sigma_rad = -1.0;
            }),
            "invalid_argument");
  EXPECT_EQ(refused([](BundleScene& s) {
              s.turns.resize(s.T_body_cam.size());
              s.turns[2].R_before_now(1, 1) = std::nan("");
            }),
            "invalid_argument");
  EXPECT_EQ(refused([](BundleScene& s) { s.geometry.baseline_m = 0.0; }), "bad_calibration");
  EXPECT_EQ(refused([](BundleScene& s) { s.geometry.fx_px = std::nan(""); }), "bad_calibration");
  const auto spoil_first = [](BundleScene& s, float BundleObservation::*member, float value) {
    const auto frame = static_cast<std::size_t>(std::countr_zero(s.points[5].frames));
    s.observation(5, frame).*member = value;
  };
  static const auto kSpoilFirst = spoil_first;
  EXPECT_EQ(refused([](BundleScene& s) { kSpoilFirst(s, &BundleObservation::u_left_px, kNoRight); }),
            "invalid_argument");
  EXPECT_EQ(refused([](BundleScene& s) { kSpoilFirst(s, &BundleObservation::v_px, kNoRight); }), "invalid_argument");
  EXPECT_EQ(refused([](BundleScene& s) {
              kSpoilFirst(s, &BundleObservation::u_right_px, std::numeric_limits<float>::infinity());
            }),
            "invalid_argument");
  EXPECT_EQ(refused([](BundleScene& s) { kSpoilFirst(s, &BundleObservation::inverse_sigma_px, 0.F); }),
            "invalid_argument");
}

TEST(FixedBundleAdjuster, SameInputGivesTheSameBits) {
  FixedSolver solver({});
  BundleScene first = make_scene({});
  BundleScene second = first;
  SceneOptions other_options;
  other_options.seed = 9;
  other_options.frames = 7;
  BundleScene other = make_scene(other_options);
  BundleWindow first_window = first.window();
  BundleWindow other_window = other.window();
  BundleWindow second_window = second.window();
  const auto a = solver.adjuster.refine(first_window);
  ASSERT_TRUE(solver.adjuster.refine(other_window));
  const auto b = solver.adjuster.refine(second_window);
  ASSERT_TRUE(a && b);
  EXPECT_TRUE(same_bits(first.T_body_cam, second.T_body_cam));
  EXPECT_TRUE(same_points(first.points, second.points));
  EXPECT_EQ(a->final_cost, b->final_cost);
  EXPECT_EQ(a->newest_covariance, b->newest_covariance);
}

TEST(FixedBundleAdjuster, RefinesWithoutAllocating) {
  if (!allocation_counting_available()) {
    GTEST_SKIP() << "allocations are not counted in this build";
  }
  FixedSolver solver({});
  BundleScene scene = make_scene({});
  BundleWindow window = scene.window();
  const std::uint64_t before = allocation_counts().own;
  const auto summary = solver.adjuster.refine(window);
  const std::uint64_t after = allocation_counts().own;
  ASSERT_TRUE(summary);
  EXPECT_EQ(after - before, 0U);
}

/// Root mean square angle error of the free poses over some noisy windows.
double angle_error_rad(SceneOptions options) {
  FixedSolver solver(patient_config());
  double sum = 0.0;
  int count = 0;
  for (options.seed = 1; options.seed <= 24; ++options.seed) {
    BundleScene scene = make_scene(options);
    BundleWindow window = scene.window();
    EXPECT_TRUE(solver.adjuster.refine(window));
    for (std::size_t k = 1; k < scene.T_body_cam.size(); ++k) {
      const double error_rad = difference(scene.T_body_cam[k], scene.true_T_body_cam[k]).angle_rad;
      sum += error_rad * error_rad;
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

TEST(FixedBundleAdjuster, WhatIsExpectedOfATurnHoldsAnAttitudeThatPointsHardlyTell) {
  SceneOptions options;
  options.points = 12;
  options.track_frames = 10;
  options.noise_px = 1.0;
  const double alone_rad = angle_error_rad(options);
  options.turn_sigma_rad = 1e-4;
  EXPECT_LT(angle_error_rad(options), 0.6 * alone_rad);
}

TEST(FixedBundleAdjuster, ASignificantTurnOutweighsThePrior) {
  SceneOptions options;
  options.points = 60;
  options.track_frames = 10;
  const double alone_rad = angle_error_rad(options);
  options.turn_sigma_rad = 0.004;
  options.unexpected_turn_rad = 0.02;  // Nine sigmas in total.
  EXPECT_LT(angle_error_rad(options), 1.2 * alone_rad + 2e-5);
}

TEST(FixedBundleAdjuster, ALimitBoundsIterationsUntilItIsLifted) {
  FixedSolver solver(patient_config());
  const auto iterations = [&](int most) {
    solver.adjuster.limit(most);
    BundleScene scene = make_scene({});
    BundleWindow window = scene.window();
    return solver.adjuster.refine(window).value().iterations;
  };
  const int all = iterations(1000);
  ASSERT_GT(all, 2);
  EXPECT_EQ(iterations(2), 2);
  EXPECT_EQ(iterations(1000), all) << "never more than configured, and all of that again";
}

}  // namespace
}  // namespace kinetrace::refinement

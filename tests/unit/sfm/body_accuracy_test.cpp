// Accuracy of the reconstruction: errors against exact truth, with a feature tracker's noise and outliers.
#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "body_driver.hpp"
#include "synthetic_world.hpp"

namespace kinetrace::sfm {
namespace {

using kinetrace::test::driven;
using kinetrace::test::rotation_error_deg;
using kinetrace::test::SyntheticWorld;
using kinetrace::test::turned;
using kinetrace::test::WorldConfig;
using test::BodyDriver;

constexpr double kStep_m = 0.8;  // A frame at 8 m/s and 10 Hz.

/// Errors over a run, root mean square.
class Rms {
 public:
  void add(double error) {
    sum_ += error * error;
    ++count_;
  }
  [[nodiscard]] double value() const { return count_ > 0 ? std::sqrt(sum_ / count_) : 0.0; }

 private:
  double sum_ = 0.0;
  int count_ = 0;
};

TEST(BodyAccuracy, ADriveOfAHundredMetresDriftsByCentimetres) {
  Rms drift_percent;
  Rms rotation_deg;
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    SyntheticWorld world({.wrong_track_ratio = 0.1, .wrong_right_ratio = 0.05, .seed = seed});
    BodyDriver driver{BodyConfig{}};
    Se3 truth;
    for (int i = 0; i <= 125; ++i) {
      truth = driven(kStep_m * i, 0.005);
      ASSERT_EQ(driver.step(world.observe(truth)).status, BodyStatus::kTracked);
    }
    const Se3 error = truth.inverse() * driver.body().estimate().T_body_cam;
    drift_percent.add(error.translation.norm());
    rotation_deg.add(rotation_error_deg(truth, driver.body().estimate().T_body_cam));
  }
  RecordProperty("drift_percent", std::to_string(drift_percent.value()));
  RecordProperty("rotation_deg_per_100_m", std::to_string(rotation_deg.value()));
  EXPECT_LT(drift_percent.value(), 0.05);
  EXPECT_LT(rotation_deg.value(), 0.08);
}

TEST(BodyAccuracy, CovariancesTellHowFarTheBodysFrameHasDrifted) {
  double by_all = 0.0;
  double by_newest = 0.0;
  constexpr int kRuns = 8;
  for (std::uint32_t seed = 1; seed <= kRuns; ++seed) {
    SyntheticWorld world({.seed = 100 + seed});
    BodyDriver driver{BodyConfig{}};
    Se3 truth;
    for (int i = 0; i <= 80; ++i) {
      truth = driven(kStep_m * i, 0.005);
      driver.step(world.observe(truth));
    }
    const BodyEstimate& e = driver.body().estimate();
    const Vector6d error = left_difference(truth, e.T_body_cam);
    by_all += error.dot((e.covariance + e.drift_covariance).ldlt().solve(error)) / (6.0 * kRuns);
    by_newest += error.dot(e.covariance.ldlt().solve(error)) / (6.0 * kRuns);
  }
  RecordProperty("squared_error_by_covariance", std::to_string(by_all));
  EXPECT_GT(by_all, 0.3);
  EXPECT_LT(by_all, 2.0);
  EXPECT_GT(by_newest, 5.0) << "most of it is older than the window";
}

TEST(BodyAccuracy, AStandingRigDoesNotDrift) {
  SyntheticWorld world({.wrong_track_ratio = 0.05, .wrong_right_ratio = 0.02, .seed = 11});
  BodyDriver driver{BodyConfig{}};
  double worst_m = 0.0;
  double worst_deg = 0.0;
  for (int i = 0; i < 200; ++i) {
    const BodyEstimate& e = driver.step(world.observe({}));
    worst_m = std::max(worst_m, e.T_body_cam.translation.norm());
    worst_deg = std::max(worst_deg, rotation_error_deg(e.T_body_cam, {}));
  }
  RecordProperty("worst_cm", std::to_string(100.0 * worst_m));
  EXPECT_LT(worst_m, 0.03);
  EXPECT_LT(worst_deg, 0.1);
}

TEST(BodyAccuracy, AMapOfFewPointsStandsStillToo) {
  // Objects and poor scenes: the map is full and features are few.
  SyntheticWorld world({.background_features = 60, .seed = 12});
  BodyConfig config;
  config.max_points = 80;
  BodyDriver driver{config};
  double worst_m = 0.0;
  for (int i = 0; i < 200; ++i) {
    worst_m = std::max(worst_m, driver.step(world.observe({})).T_body_cam.translation.norm());
  }
  EXPECT_LT(worst_m, 0.05);
}

TEST(BodyAccuracy, StandingStillAmidADriveLosesNothing) {
  SyntheticWorld world({.seed = 13});
  BodyDriver driver{BodyConfig{}};
  Se3 truth;
  for (int i = 0; i < 40; ++i) {
    truth = driven(kStep_m * i);
    driver.step(world.observe(truth));
  }
  const double before_m = (truth.inverse() * driver.body().estimate().T_body_cam).translation.norm();
  double after_m = 0.0;
  for (int i = 0; i < 100; ++i) {
    after_m = (truth.inverse() * driver.step(world.observe(truth)).T_body_cam).translation.norm();
  }
  EXPECT_LT(after_m, before_m + 0.01);
}

/// Depth errors of points 20 m ahead while the rig moves sideways past them.
struct DepthErrors {
  Rms single_frame;
  Rms window;
};

DepthErrors depth_errors(double depth_m, double sideways_m) {
  SyntheticWorld world({.background_features = 300,
                        .nearest_m = 0.95 * depth_m,
                        .farthest_m = 1.05 * depth_m,
                        .min_track_frames = 30,
                        .max_track_frames = 40,
                        .right_ratio = 1.0,
                        .seed = 21});
  BodyConfig config;
  config.keyframe_motion_px = 0.0;  // Every frame stays: a window of ten frames.
  BodyDriver driver{config};
  const StereoGeometry rig = kinetrace::test::street_rig();
  DepthErrors errors;
  for (int i = 0; i < 10; ++i) {
    const Se3 truth = turned(0.0, {sideways_m * i, 0.0, 0.0});
    const FeatureFrame frame = world.observe(truth);
    const BodyEstimate& e = driver.step(frame);
    if (i < 9) {
      continue;
    }
    for (const Feature& f : frame.features) {
      const double z = (truth.inverse() * world.truth(f).p_body).z();
      if (f.has_right()) {
        errors.single_frame.add(rig.depth_m(double{f.disparity_px()}) - z);
      }
    }
    for (const BodyPoint& p : e.points) {
      if (p.observations == 10) {
        errors.window.add((truth.inverse() * p.position_m.cast<double>() - truth.inverse() * world.point_of(p.id)).z());
      }
    }
  }
  return errors;
}

TEST(BodyAccuracy, TemporalViewsAtLeastHalveTheDepthErrorOfStereo) {
  // The paper's central claim. At rest, ten frames average the noise; in motion, parallax adds information.
  for (const double sideways_m : {0.05, 0.3}) {
    const DepthErrors errors = depth_errors(20.0, sideways_m);
    RecordProperty("single_frame_m", std::to_string(errors.single_frame.value()));
    RecordProperty("window_m", std::to_string(errors.window.value()));
    EXPECT_NEAR(errors.single_frame.value(), 0.436, 0.06);  // z^2 / (f b) sqrt(2) sigma.
    EXPECT_LT(2.0 * errors.window.value(), errors.single_frame.value()) << "moving " << sideways_m << " m a frame";
  }
}

/// Pose errors of a box that drives ahead of the camera like a car.
struct ObjectErrors {
  Rms newest_m;
  Rms step_m;
  Rms step_deg;
  int tracked = 0;
};

ObjectErrors follow_object(const WorldConfig& config, double distance_m, double turn_rad, int frames,
                           double turn_rate_radps = 0.0) {
  SyntheticWorld world(config, {{}});
  BodyConfig body;
  body.max_points = 160;
  body.turn_rate_radps = turn_rate_radps;
  BodyDriver driver(body);
  ObjectErrors errors;
  const auto T_world_cam = [](int i) { return driven(kStep_m * i); };
  const auto T_world_obj = [&](int i) { return driven(distance_m + kStep_m * i, turn_rad / kStep_m) * turned(-1.2); };
  Se3 last_estimate;
  Se3 last_truth;
  for (int i = 0; i < frames; ++i) {
    const Se3 camera = T_world_cam(i);
    const std::vector<Se3> object{T_world_obj(i)};
    const Se3 truth = object[0].inverse() * camera;
    const BodyEstimate& e = driver.step(world.observe(camera, object), 1, truth, &camera.rotation);
    errors.tracked += e.status == BodyStatus::kTracked ? 1 : 0;
    const Se3 T_cam_obj = e.T_body_cam.inverse();
    errors.newest_m.add((T_cam_obj.translation - truth.inverse().translation).norm());
    if (i > 10) {  // Motion of the object from frame to frame, seen in the world (eq. 2 with an exact camera).
      const Se3 T_world_now = camera * T_cam_obj;
      const Se3 step_error = (last_truth.inverse() * object[0]).inverse() * (last_estimate.inverse() * T_world_now);
      errors.step_m.add(step_error.translation.norm());
      errors.step_deg.add(rotation_error_deg(step_error, {}));
    }
    last_estimate = camera * T_cam_obj;
    last_truth = object[0];
  }
  return errors;
}

TEST(BodyAccuracy, ACarFifteenMetresAheadMovesWithinCentimetres) {
  const ObjectErrors e = follow_object({.background_features = 0, .seed = 31}, 15.0, 0.0, 40);
  RecordProperty("newest_m", std::to_string(e.newest_m.value()));
  RecordProperty("step_m", std::to_string(e.step_m.value()));
  RecordProperty("step_deg", std::to_string(e.step_deg.value()));
  EXPECT_EQ(e.tracked, 40);
  EXPECT_LT(e.newest_m.value(), 0.1);
  EXPECT_LT(e.step_m.value(), 0.05);
  EXPECT_LT(e.step_deg.value(), 0.3);
}

TEST(BodyAccuracy, ATurningCarWithWrongTracksIsFollowed) {
  const ObjectErrors e = follow_object(
      {.background_features = 0, .wrong_track_ratio = 0.15, .wrong_right_ratio = 0.05, .seed = 32}, 12.0, 0.01, 30);
  EXPECT_EQ(e.tracked, 30);
  EXPECT_LT(e.newest_m.value(), 0.15);
  EXPECT_LT(e.step_m.value(), 0.06);
  EXPECT_LT(e.step_deg.value(), 0.4);
}

TEST(BodyAccuracy, AFarCarDoesNotTalkItselfIntoTurning) {
  // Few distant points hardly constrain a pose; the prior of marginalised frames must not outweigh observations.
  Rms newest_m;
  Rms step_deg;
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    const ObjectErrors e =
        follow_object({.background_features = 0, .wrong_track_ratio = 0.05, .seed = seed}, 40.0, 0.0, 40);
    EXPECT_EQ(e.tracked, 40);
    newest_m.add(e.newest_m.value());
    step_deg.add(e.step_deg.value());
  }
  EXPECT_LT(newest_m.value(), 0.4);
  EXPECT_LT(step_deg.value(), 0.7);
}

/// Attitude error, in degrees, of a trolley that approaches a static rig with a baseline of 10 cm, 40 frames after
/// the first observation.
double trolley_off_deg(double turn_rate_radps, std::uint32_t seed) {
  const StereoGeometry rig{400.0, 400.0, 319.5, 239.5, 0.1, 640, 480};
  SyntheticWorld world({.geometry = rig,
                        .background_features = 0,
                        .sigma_px = 0.15,
                        .noise_persistence = 0.5,
                        .min_track_frames = 4,
                        .max_track_frames = 25,
                        .frame_interval_s = 0.04,
                        .seed = seed},
                       {{.size_m = {0.8, 1.0, 0.6}, .features = 14}});
  BodyConfig config;
  config.max_points = 160;
  config.keyframe_motion_px = 2.0;
  config.min_inliers = 4;
  config.turn_rate_radps = turn_rate_radps;
  BodyDriver driver(config, rig);
  const Se3 camera;
  Se3 truth;
  for (int i = 0; i < 40; ++i) {
    const std::vector<Se3> trolley{turned(-0.6, {1.0, 0.2, 10.0 - 0.06 * i})};
    truth = trolley[0].inverse() * camera;
    driver.step(world.observe(camera, trolley), 1, truth, &camera.rotation);
  }
  return rotation_error_deg(truth, driver.body().estimate().T_body_cam);
}

TEST(BodyAccuracy, FewPointsOnASmallBaselineDoNotTurnWhatComesStraight) {
  Rms free_deg;
  Rms expected_deg;
  for (std::uint32_t seed = 1; seed <= 24; ++seed) {
    free_deg.add(trolley_off_deg(0.0, seed));
    expected_deg.add(trolley_off_deg(0.1, seed));
  }
  RecordProperty("free_deg", std::to_string(free_deg.value()));
  RecordProperty("expected_deg", std::to_string(expected_deg.value()));
  EXPECT_LT(expected_deg.value(), 0.7 * free_deg.value());
}

TEST(BodyAccuracy, ATurningCarIsFollowedThoughItIsNotExpectedToTurn) {
  const WorldConfig config{.background_features = 0, .seed = 32};
  constexpr double kTurn_rad = 0.02;  // 0.2 rad/s.
  const ObjectErrors free = follow_object(config, 12.0, kTurn_rad, 20);
  const ObjectErrors expected = follow_object(config, 12.0, kTurn_rad, 20, 0.1);
  EXPECT_EQ(free.tracked, 20);
  EXPECT_EQ(expected.tracked, 20);
  EXPECT_LT(expected.newest_m.value(), 1.1 * free.newest_m.value() + 0.005);
  EXPECT_LT(expected.step_deg.value(), 1.1 * free.step_deg.value() + 0.01);
}

TEST(BodyAccuracy, BackgroundAndObjectAreSeparatedByTheirLabelAlone) {
  // Both bodies in the same frames; the object must not affect the background.
  SyntheticWorld world({.background_features = 300, .seed = 33}, {{.features = 150}});
  BodyDriver background{BodyConfig{}};
  BodyDriver object{BodyConfig{}};
  for (int i = 0; i < 30; ++i) {
    const Se3 camera = driven(kStep_m * i);
    const std::vector<Se3> box{turned(0.0, {2.0, 0.5, 12.0 + 1.1 * i})};
    const FeatureFrame frame = world.observe(camera, box);
    const Se3 T_obj_cam = box[0].inverse() * camera;
    background.step(frame, 0);
    object.step(frame, 1, T_obj_cam);
    EXPECT_LT((background.body().estimate().T_body_cam.translation - camera.translation).norm(), 0.05);
    const Se3 T_cam_obj = object.body().estimate().T_body_cam.inverse();
    EXPECT_LT((T_cam_obj.translation - T_obj_cam.inverse().translation).norm(), 0.1);
  }
}

TEST(BodyAccuracy, TransformingTheWorldChangesNothing) {
  const std::vector<Se3> worlds{turned(0.7, {3.0, -2.0, 1.0}), {so3_exp({0.4, -2.0, 0.3}), {1000.0, -50.0, 2000.0}}};
  for (const Se3& T_new_old : worlds) {
    SyntheticWorld world({.wrong_track_ratio = 0.1, .seed = 41});
    BodyDriver original{BodyConfig{}};
    BodyDriver moved{BodyConfig{}};
    for (int i = 0; i < 25; ++i) {
      const FeatureFrame frame = world.observe(driven(kStep_m * i, 0.01));
      const BodyEstimate& a = original.step(frame);
      const BodyEstimate& b = moved.step(frame, 0, T_new_old);
      EXPECT_LT((T_new_old * a.T_body_cam.translation - b.T_body_cam.translation).norm(), 2e-3) << "frame " << i;
      EXPECT_LT(rotation_error_deg(T_new_old * a.T_body_cam, b.T_body_cam), 2e-3) << "frame " << i;
      EXPECT_NEAR(a.inliers, b.inliers, 3);
      EXPECT_EQ(a.is_keyframe, b.is_keyframe);
    }
  }
}

TEST(BodyAccuracy, SameInputSameOutputBitForBit) {
  BodyDriver first{BodyConfig{}};
  BodyDriver second{BodyConfig{}};
  SyntheticWorld world({.wrong_track_ratio = 0.1, .seed = 51});
  for (int i = 0; i < 20; ++i) {
    const FeatureFrame frame = world.observe(driven(kStep_m * i));
    const BodyEstimate& a = first.step(frame);
    const BodyEstimate& b = second.step(frame);
    ASSERT_EQ(a.T_body_cam.translation, b.T_body_cam.translation);
    ASSERT_EQ(a.T_body_cam.rotation, b.T_body_cam.rotation);
    ASSERT_EQ(a.covariance, b.covariance);
    ASSERT_EQ(a.points.size(), b.points.size());
  }
}

TEST(BodyAccuracy, TheClaimedCovarianceIsHonestFromFrameToFrame) {
  // The covariance is that of the error against the oldest frame of the window; early on that is the first frame.
  Vector6d normalised = Vector6d::Zero();
  constexpr int kRuns = 60;
  for (int run = 0; run < kRuns; ++run) {
    SyntheticWorld world({.background_features = 150, .seed = 100U + static_cast<std::uint32_t>(run)});
    BodyConfig config;
    config.measurement_sigma_px = 0.3;
    BodyDriver driver{config};
    for (int i = 0; i < 5; ++i) {
      driver.step(world.observe(driven(kStep_m * i)));
    }
    const BodyEstimate& e = driver.body().estimate();
    const Vector6d error = left_difference(driven(kStep_m * 4), e.T_body_cam);
    normalised += error.cwiseAbs2().cwiseQuotient(e.covariance.diagonal()) / kRuns;
  }
  for (int i = 0; i < 6; ++i) {
    EXPECT_GT(normalised[i], 0.4) << "axis " << i;
    EXPECT_LT(normalised[i], 2.5) << "axis " << i;
  }
}

}  // namespace
}  // namespace kinetrace::sfm

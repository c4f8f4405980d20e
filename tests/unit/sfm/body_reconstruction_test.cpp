// States, capacities and the contract of the four calls.
#include "kinetrace/sfm/body_reconstruction.hpp"

#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "body_driver.hpp"
#include "synthetic_world.hpp"

namespace kinetrace::sfm {
namespace {

using kinetrace::test::driven;
using kinetrace::test::street_rig;
using kinetrace::test::SyntheticWorld;
using kinetrace::test::turned;
using test::BodyDriver;
using ::testing::HasSubstr;

constexpr double kStep_m = 0.8;  // A frame at 8 m/s and 10 Hz.

double position_error_m(const Se3& T_body_cam, const Se3& truth) {
  return (T_body_cam.translation - truth.translation).norm();
}

TEST(BodyReconstruction, TakesExactlyWhatItSays) {
  const BodyConfig config;
  Arena arena(BodyReconstruction::required_bytes(config));
  ASSERT_TRUE(BodyReconstruction::create(config, street_rig(), arena));
  EXPECT_EQ(arena.used_bytes(), arena.capacity_bytes());
}

TEST(BodyReconstruction, RefusesAnArenaThatIsTooSmall) {
  const BodyConfig config;
  Arena arena(BodyReconstruction::required_bytes(config) - 1);
  const auto body = BodyReconstruction::create(config, street_rig(), arena);
  ASSERT_FALSE(body);
  EXPECT_EQ(body.error().code, ErrorCode::kCapacity);
  EXPECT_THAT(body.error().message, HasSubstr("memory plan"));
}

TEST(BodyReconstruction, RefusesABadConfigurationOrRig) {
  Arena arena(1 << 20);
  BodyConfig config;
  config.window_frames = 0;
  EXPECT_EQ(BodyReconstruction::create(config, street_rig(), arena).error().code, ErrorCode::kInvalidConfig);
  StereoGeometry rig = street_rig();
  rig.baseline_m = 0.0;
  EXPECT_EQ(BodyReconstruction::create(BodyConfig{}, rig, arena).error().code, ErrorCode::kBadCalibration);
  rig.baseline_m = std::nan("");
  EXPECT_EQ(BodyReconstruction::create(BodyConfig{}, rig, arena).error().code, ErrorCode::kBadCalibration);
}

TEST(BodyReconstruction, IsInactiveUntilBegun) {
  BodyDriver driver{BodyConfig{}};
  EXPECT_FALSE(driver.body().active());
  EXPECT_EQ(driver.body().history_size(), 0U);
  driver.body().begin(turned(0.1));
  EXPECT_TRUE(driver.body().active());
  EXPECT_EQ(driver.body().estimate().status, BodyStatus::kTracked);
}

TEST(BodyReconstruction, TheFirstFrameIsWhereItWasBegun) {
  SyntheticWorld world({});
  BodyDriver driver{BodyConfig{}};
  const Se3 T = turned(0.3, {5.0, -1.0, 7.0});
  const BodyEstimate& e = driver.step(world.observe(T), 0, T);
  EXPECT_EQ(e.status, BodyStatus::kTracked);
  EXPECT_LT(position_error_m(e.T_body_cam, T), 1e-12);
  EXPECT_TRUE(e.is_keyframe);
  EXPECT_GT(e.points.size(), 500U);
  EXPECT_EQ(e.frame_observations.size(), e.points.size());
  EXPECT_EQ(driver.body().history_size(), 1U);
}

TEST(BodyReconstruction, RestartsAtItsOwnEstimate) {
  BodyDriver driver{BodyConfig{}};
  const Se3 where = driven(3.0);
  driver.body().begin(where);
  driver.body().begin(driver.body().estimate().T_body_cam, BodyStatus::kPropagated);
  EXPECT_LT(position_error_m(driver.body().estimate().T_body_cam, where), 1e-9);
}

TEST(BodyReconstruction, AFirstFrameWithoutFeaturesIsStillAFrame) {
  SyntheticWorld world({.background_features = 0});
  BodyDriver driver{BodyConfig{}};
  const BodyEstimate& e = driver.step(world.observe({}));
  EXPECT_EQ(e.points.size(), 0U);
  EXPECT_EQ(e.status, BodyStatus::kTracked);
  EXPECT_EQ(driver.step(world.observe({})).status, BodyStatus::kPropagated);
}

TEST(BodyReconstruction, FramesWithoutFeaturesKeepTheLastSpeedAndBeginRecovers) {
  SyntheticWorld world({});
  const BodyConfig config;
  BodyDriver driver{config};
  int i = 0;
  for (; i < 12; ++i) {
    driver.step(world.observe(driven(kStep_m * i)));
  }
  const std::size_t points_before = driver.body().estimate().points.size();
  for (; i < 15; ++i) {
    const BodyEstimate& e = driver.step(world.observe_nothing());
    EXPECT_EQ(e.status, BodyStatus::kPropagated);
    EXPECT_EQ(e.inliers, 0);
    EXPECT_TRUE(e.frame_observations.empty());
    EXPECT_FALSE(e.is_keyframe);
    EXPECT_LT(position_error_m(e.T_body_cam, driven(kStep_m * i)), 0.1);
    EXPECT_EQ(e.points.size(), points_before);
  }
  EXPECT_EQ(driver.body().history(0).status, BodyStatus::kPropagated);

  // Features are back, but without known points: restart at the predicted pose.
  const FeatureFrame frame = world.observe(driven(kStep_m * i));
  const BodyEstimate& lost = driver.body().locate(frame, 0);
  EXPECT_EQ(lost.status, BodyStatus::kPropagated);
  driver.body().begin(lost.T_body_cam, BodyStatus::kPropagated);
  const BodyEstimate& begun = driver.finish(frame);
  EXPECT_EQ(begun.status, BodyStatus::kPropagated);
  EXPECT_GT(begun.points.size(), 500U);
  EXPECT_GT(begun.retired.size(), points_before / 2);
  for (++i; i < 30; ++i) {
    const BodyEstimate& e = driver.step(world.observe(driven(kStep_m * i)));
    EXPECT_EQ(e.status, BodyStatus::kTracked);
    EXPECT_LT(position_error_m(e.T_body_cam, driven(kStep_m * i)), 0.15);
  }
  // The path continues through the restart.
  EXPECT_EQ(driver.body().history_size(), static_cast<std::size_t>(config.window_frames) + 1);
}

TEST(BodyReconstruction, APredictedPoseIsWorthLessThanAMeasuredOne) {
  SyntheticWorld world({});
  BodyDriver driver{BodyConfig{}};
  for (int i = 0; i < 5; ++i) {
    driver.step(world.observe(driven(kStep_m * i)));
  }
  const Matrix6d measured = driver.body().estimate().covariance;
  const FeatureFrame nothing = world.observe_nothing();
  const Matrix6d predicted = driver.step(nothing).covariance;
  EXPECT_GT(predicted(5, 5), 100.0 * measured(5, 5));
  EXPECT_GT(driver.step(world.observe_nothing()).covariance(5, 5), predicted(5, 5));
  // A restart at a predicted pose does not make it certain.
  const FeatureFrame frame = world.observe(driven(kStep_m * 7));
  driver.body().begin(driver.body().locate(frame, 0).T_body_cam, BodyStatus::kPropagated);
  EXPECT_GT(driver.finish(frame).covariance(5, 5), predicted(5, 5));
}

TEST(BodyReconstruction, AFewFeaturesAreNoPose) {
  BodyConfig config;
  config.min_inliers = 8;
  for (const int features : {7, 30}) {
    SyntheticWorld world({.background_features = features, .min_track_frames = 20, .right_ratio = 1.0});
    BodyDriver driver{config};
    driver.step(world.observe({}));
    EXPECT_EQ(driver.step(world.observe({})).status, features < 8 ? BodyStatus::kPropagated : BodyStatus::kTracked);
  }
}

TEST(BodyReconstruction, EndRetiresWhatIsLeftAndKeepsTheHistory) {
  SyntheticWorld world({});
  BodyDriver driver{BodyConfig{}};
  for (int i = 0; i < 5; ++i) {
    driver.step(world.observe(driven(kStep_m * i)));
  }
  const Se3 last = driver.body().history(0).T_body_cam;
  driver.body().end();
  EXPECT_FALSE(driver.body().active());
  EXPECT_GT(driver.body().estimate().retired.size(), 300U);
  EXPECT_TRUE(driver.body().estimate().points.empty());
  EXPECT_EQ(driver.body().history_size(), 5U);
  EXPECT_EQ(driver.body().history(0).T_body_cam.translation, last.translation);
  driver.body().begin({});
  EXPECT_EQ(driver.body().history_size(), 0U);
}

TEST(BodyReconstruction, HoldsMaxPointsAndCountsWhatItDrops) {
  for (const int extra : {0, 1}) {
    const int features = 100;
    SyntheticWorld world({.background_features = features, .min_track_frames = 25});
    BodyConfig config;
    config.max_points = features - extra;
    BodyDriver driver{config};
    driver.step(world.observe({}));
    EXPECT_EQ(driver.body().counters().points_dropped, static_cast<std::uint64_t>(extra));
  }
}

TEST(BodyReconstruction, AFullMapGivesUpPointsThatAreGoneNotThoseThatAreSeen) {
  // As many features as the map holds: each track that ends must make room for the next one.
  const int features = 200;
  SyntheticWorld world({.background_features = features, .max_track_frames = 10});
  BodyConfig config;
  config.max_points = features;
  BodyDriver driver{config};
  for (int i = 0; i < 60; ++i) {
    const BodyEstimate& e = driver.step(world.observe({}));
    EXPECT_LE(e.points.size(), static_cast<std::size_t>(features));
    EXPECT_GT(e.inliers, features / 2) << "frame " << i;
  }
  EXPECT_GT(driver.body().counters().points_evicted, 500U);
  EXPECT_LT(driver.body().counters().points_dropped, 20U);
}

TEST(BodyReconstruction, TheLongestAndTheShortestWindowWork) {
  for (const int window : {3, 32}) {
    SyntheticWorld world({.background_features = 200, .max_track_frames = 40});
    BodyConfig config;
    config.window_frames = window;
    BodyDriver driver{config};
    for (int i = 0; i < 40; ++i) {
      driver.step(world.observe(driven(kStep_m * i)));
    }
    EXPECT_EQ(driver.body().estimate().status, BodyStatus::kTracked);
    EXPECT_LT(position_error_m(driver.body().estimate().T_body_cam, driven(kStep_m * 39)), 0.15) << window;
    EXPECT_EQ(driver.body().history_size(), static_cast<std::size_t>(window) + 1);
  }
}

TEST(BodyReconstruction, AWindowOfOneFrameIsSingleFrameStereo) {
  SyntheticWorld world({.background_features = 200, .sigma_px = 0.2, .max_track_frames = 40});
  BodyConfig config;
  config.window_frames = 1;
  BodyDriver driver{config, street_rig(), {.max_frames = 2, .max_points = config.max_points}};
  for (int i = 0; i < 20; ++i) {
    const BodyEstimate& e = driver.step(world.observe(driven(kStep_m * i)));
    ASSERT_EQ(e.status, BodyStatus::kTracked);
    ASSERT_EQ(e.points.size(), e.frame_observations.size());
    for (std::size_t j = 0; j < e.points.size(); ++j) {
      const PointObservation& o = e.frame_observations[j];
      const double disparity_px = double{o.u_left_px} - double{o.u_right_px};
      if (disparity_px >= config.min_disparity_px) {  // false without a right observation
        const Eigen::Vector3d seen =
            e.T_body_cam * street_rig().triangulate(double{o.u_left_px}, double{o.v_px}, disparity_px);
        EXPECT_LT((e.points[j].position_m.cast<double>() - seen).norm(), 1e-3) << "frame " << i;
      }
    }
  }
  EXPECT_LT(position_error_m(driver.body().estimate().T_body_cam, driven(kStep_m * 19)), 1.0);
}

TEST(BodyReconstruction, WindowHoldsItsContractWithTheAdjuster) {
  SyntheticWorld world({.background_features = 200});
  BodyConfig config;
  config.window_frames = 6;
  BodyDriver driver{config};
  for (int i = 0; i < 12; ++i) {
    driver.step(world.observe(driven(kStep_m * i)));
    const BundleWindow window = driver.body().window();
    ASSERT_EQ(window.T_body_cam.size(), 6U);
    ASSERT_EQ(window.observations.size(), window.points.size() * 6U);
    EXPECT_NE(window.fixed_frames, 0U);
    if (i > 0) {
      EXPECT_EQ(window.fixed_frames >> 5U, 0U) << "the newest pose is free";
    }
    for (std::size_t row = 0; row < window.points.size(); ++row) {
      ASSERT_EQ(window.points[row].frames >> 6U, 0U);
      for (std::size_t k = 0; k < 6; ++k) {
        if ((window.points[row].frames >> k & 1U) != 0) {
          ASSERT_TRUE(std::isfinite(window.observation(row, k).u_left_px));
          ASSERT_GT(window.observation(row, k).inverse_sigma_px, 0.F);
        }
      }
    }
  }
}

TEST(BodyReconstruction, NothingMovesWithoutANewPose) {
  SyntheticWorld world({});
  BodyDriver driver{BodyConfig{}};
  for (int i = 0; i < 5; ++i) {
    driver.step(world.observe(driven(kStep_m * i)));
  }
  driver.step(world.observe_nothing());
  const BundleWindow window = driver.body().window();
  EXPECT_EQ(window.fixed_frames, (1U << window.T_body_cam.size()) - 1U);
}

TEST(BodyReconstruction, HistoryFinalisesAfterTheWindow) {
  SyntheticWorld world({.wrong_track_ratio = 0.05});
  const BodyConfig config;
  const auto lag = static_cast<std::size_t>(config.window_frames);
  BodyDriver driver{config};
  double finalised_error_m = 0.0;  // Of one step.
  std::vector<Se3> finalised;
  for (int i = 0; i < 60; ++i) {
    const Se3 truth = driven(kStep_m * i, 0.005);
    driver.step(world.observe(truth));
    ASSERT_LE(driver.body().history_size(), lag + 1);
    if (driver.body().history_size() == lag + 1) {
      const FinalisedPose pose = driver.body().history(lag);
      EXPECT_EQ(pose.frame_index, i - config.window_frames);
      EXPECT_EQ(pose.status, BodyStatus::kTracked);
      EXPECT_GT(pose.inliers, 100);
      finalised.push_back(pose.T_body_cam);
    }
    if (finalised.size() >= 2) {
      const Se3 step = driven(kStep_m * (i - 1), 0.005).inverse() * truth;
      finalised_error_m = std::max(
          finalised_error_m,
          (step.inverse() * (finalised[finalised.size() - 2].inverse() * finalised.back())).translation.norm());
    }
  }
  EXPECT_EQ(finalised.size(), 60U - lag);
  EXPECT_LT(finalised_error_m, 0.005);
}

TEST(BodyReconstruction, ARedundantFrameMakesRoomAndAMovingOneIsKept) {
  SyntheticWorld world({.background_features = 200, .min_track_frames = 50, .max_track_frames = 60});
  BodyDriver driver{BodyConfig{}};
  driver.step(world.observe({}));
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(driver.step(world.observe({})).is_keyframe);
  }
  for (int i = 1; i < 4; ++i) {
    EXPECT_TRUE(driver.step(world.observe(driven(3.0 * i))).is_keyframe);
  }
}

TEST(BodyReconstruction, PredictsWhereFeaturesWillBe) {
  SyntheticWorld world({.sigma_px = 0.0, .min_track_frames = 25});
  BodyDriver driver{BodyConfig{}};
  FeatureFrame frame;
  for (int i = 0; i < 6; ++i) {
    frame = world.observe(driven(kStep_m * i, 0.01));
    driver.step(frame);
  }
  const std::vector<Feature> previous(frame.features.begin(), frame.features.end());
  std::vector<FeaturePrediction> predicted(1200);
  driver.body().predict_features(previous, 0, 1'600'000'000, predicted);
  const FeatureFrame next = world.observe(driven(kStep_m * 6, 0.01));
  ASSERT_EQ(next.timestamp_ns, 1'600'000'000);
  int compared = 0;
  for (const Feature& f : next.features) {
    if (f.age_frames > 0 && predicted[f.slot].known) {
      EXPECT_LT((predicted[f.slot].left_px - f.left_px).norm(), 0.5F);
      if (f.has_right()) {
        EXPECT_NEAR(predicted[f.slot].disparity_px, f.disparity_px(), 0.1F);
      }
      ++compared;
    }
  }
  EXPECT_GT(compared, 400);
}

TEST(BodyReconstruction, PredictsNothingForOtherBodiesOrBeforeItHasMoved) {
  SyntheticWorld world({});
  BodyDriver driver{BodyConfig{}};
  const FeatureFrame frame = world.observe({});
  driver.step(frame);
  std::vector<FeaturePrediction> predicted(1200);
  driver.body().predict_features(frame.features, 0, 2'000'000'000, predicted);
  const auto known = [&predicted] {
    return std::count_if(predicted.begin(), predicted.end(), [](const FeaturePrediction& p) { return p.known; });
  };
  EXPECT_EQ(known(), 0);
  const FeatureFrame second = world.observe({});
  driver.step(second);
  driver.body().predict_features(second.features, 1, 2'000'000'000, predicted);
  EXPECT_EQ(known(), 0);
}

TEST(BodyReconstruction, APredictionStretchesOverLostFrames) {
  SyntheticWorld world({.sigma_px = 0.0});
  BodyDriver driver{BodyConfig{}};
  for (int i = 0; i < 6; ++i) {
    driver.step(world.observe(driven(kStep_m * i)));
  }
  // Frame 5 was at 1.5 s; a frame is .1 s.
  EXPECT_NEAR(driver.body().predict(1'500'000'000).translation.z(), 4.0, 1e-2);
  EXPECT_NEAR(driver.body().predict(1'600'000'000).translation.z(), 4.8, 1e-2);
  EXPECT_NEAR(driver.body().predict(1'800'000'000).translation.z(), 6.4, 3e-2);
  // But not for ever.
  EXPECT_NEAR(driver.body().predict(100'000'000'000).translation.z(), 8.0, 5e-2);
}

}  // namespace
}  // namespace kinetrace::sfm

#include "kinetrace/evaluation/object_metrics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "object_scene.hpp"

namespace kinetrace::evaluation {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

ObjectMetrics evaluated(const std::vector<ObjectFrame>& scene, const ObjectConfig& config = {}) {
  return evaluate_objects(scene, config);
}

TEST(ObjectMetrics, AreZeroForTruthItself) {
  const ObjectMetrics metrics = evaluated(perfect_scene());
  EXPECT_EQ(metrics.all.tall_frames, 2U * kSceneFrames);
  EXPECT_EQ(metrics.all.covered_frames, 2U * kSceneFrames);
  EXPECT_EQ(metrics.all.id_switches, 0U);
  EXPECT_EQ(metrics.all.fragmentations, 0U);
  EXPECT_EQ(metrics.all.motion.translation_m.count(), static_cast<std::size_t>(kSceneFrames - 1));
  EXPECT_NEAR(metrics.all.motion.translation_m.max().value(), 0.0, 1e-12);
  EXPECT_NEAR(metrics.all.motion.rotation_deg.max().value(), 0.0, 1e-6);
  EXPECT_EQ(metrics.all.missing_motions, 0U);
  EXPECT_NEAR(metrics.all.distance_m.max().value(), 0.0, 1e-12);
  EXPECT_NEAR(metrics.all.center_m.max().value(), 0.0, 1e-12);
  EXPECT_NEAR(metrics.all.speed_mps.max().value(), 0.0, 1e-12);
  EXPECT_NEAR(metrics.all.heading_deg.max().value(), 0.0, 1e-9);
  EXPECT_EQ(metrics.all.found_moving_rows, metrics.all.moving_rows);
  EXPECT_THAT(metrics.false_moving, IsEmpty());
  ASSERT_EQ(metrics.objects.size(), 2U);
  EXPECT_THAT(metrics.objects[0].track_ids, ElementsAre(11));
}

TEST(ObjectMetrics, DoNotDependOnWhereTheBodyFrameIs) {
  const Se3 T_true_est{so3_exp({0.5, 1.5, -0.7}), {1.0, -0.6, 0.4}};
  const ObjectMetrics metrics = evaluated(
      spoiled_scene([&](TrackEstimate& estimate, int) { estimate.T_world_obj = estimate.T_world_obj * T_true_est; }));
  EXPECT_NEAR(metrics.all.motion.translation_m.max().value(), 0.0, 1e-9);
  EXPECT_NEAR(metrics.all.motion.rotation_deg.max().value(), 0.0, 1e-6);
  EXPECT_NEAR(metrics.all.distance_m.max().value(), 0.0, 1e-9);
  EXPECT_EQ(metrics.all.offset_m.count(), 2U);
  EXPECT_NEAR(metrics.all.offset_m.max().value(), T_true_est.translation.norm(), 1e-9);
}

TEST(ObjectMetrics, ShowAMotionErrorInTheTrueBodyFrame) {
  const ObjectMetrics metrics = evaluated(spoiled_scene([](TrackEstimate& estimate, int frame) {
    // Every frame turns by 0.5 deg too much about the true origin.
    const Se3 turn{so3_exp({0.0, 0.5 * kRadPerDeg * frame, 0.0}), Eigen::Vector3d::Zero()};
    estimate.T_world_obj = estimate.T_world_obj * turn;
  }));
  EXPECT_NEAR(metrics.all.motion.rotation_deg.mean().value(), 0.5, 1e-9);
  EXPECT_NEAR(metrics.all.motion.rotation_deg.rmse().value(), 0.5, 1e-9);
  EXPECT_NEAR(metrics.all.motion.translation_m.max().value(), 0.0, 1e-9);
}

TEST(ObjectMetrics, ShowADriftAsMotionErrorAndDistance) {
  const ObjectMetrics metrics = evaluated(spoiled_scene([](TrackEstimate& estimate, int frame) {
    estimate.T_world_obj.translation += Eigen::Vector3d(0.0, 0.02 * frame, 0.0);
  }));
  EXPECT_NEAR(metrics.objects[0].errors.motion.translation_m.mean().value(), 0.02, 1e-9);
  // About the middle of 0, 2, .. 38 cm.
  EXPECT_NEAR(metrics.objects[0].errors.distance_m.mean().value(), 0.10, 1e-9);
  EXPECT_NEAR(metrics.objects[0].errors.distance_m.max().value(), 0.19, 1e-9);
}

TEST(ObjectMetrics, AttributeAMotionToTheWeakerPose) {
  std::vector<ObjectFrame> scene = perfect_scene();
  scene[5].tracks[0].estimate->status = BodyStatus::kPropagated;
  scene[9].tracks[0].estimate->status = BodyStatus::kStereoOnly;
  const ObjectMetrics metrics = evaluated(scene);
  EXPECT_EQ(metrics.all.motion_by_source[0].translation_m.count(), 15U);  // tracked
  EXPECT_EQ(metrics.all.motion_by_source[1].translation_m.count(), 2U);   // stereo only
  EXPECT_EQ(metrics.all.motion_by_source[2].translation_m.count(), 2U);   // propagated
  ASSERT_EQ(metrics.motions.size(), 19U);
  EXPECT_EQ(metrics.motions[5].frame, 6);
  EXPECT_EQ(metrics.motions[5].track_id, 11U);
  EXPECT_EQ(metrics.motions[5].source, BodyStatus::kPropagated);
}

TEST(ObjectMetrics, CountWhatIsMissing) {
  std::vector<ObjectFrame> scene = perfect_scene();
  scene[5].tracks[0].estimate->status = BodyStatus::kLost;
  scene[9].tracks[0].estimate.reset();
  const ObjectMetrics metrics = evaluated(scene);
  EXPECT_EQ(metrics.all.covered_frames, 2U * kSceneFrames - 2U);
  EXPECT_EQ(metrics.all.missing_motions, 4U);
  EXPECT_EQ(metrics.all.motion.translation_m.count(), 15U);
}

TEST(ObjectMetrics, TakeNoMotionAcrossAMissingFrame) {
  std::vector<ObjectFrame> scene = perfect_scene();
  scene.erase(scene.begin() + 7);
  const ObjectMetrics metrics = evaluated(scene);
  EXPECT_EQ(metrics.all.motion.translation_m.count(), 17U);
  EXPECT_EQ(metrics.all.missing_motions, 0U);
}

TEST(ObjectMetrics, MeasureOnlyWhatIsTallAndNear) {
  std::vector<ObjectFrame> scene = perfect_scene();
  for (ObjectFrame& frame : scene) {
    frame.truth[0].height_px = frame.frame < 10 ? 40 : 41;
  }
  const ObjectMetrics tall = evaluated(scene);
  EXPECT_EQ(tall.objects[0].errors.tall_frames, 10U);
  EXPECT_EQ(tall.objects[0].errors.visible_frames, 20U);
  EXPECT_EQ(tall.objects[0].errors.motion.translation_m.count(), 9U);

  const ObjectMetrics near = evaluated(perfect_scene(), {.motion_range_m = 5.0, .distance_range_m = 5.0});
  EXPECT_FALSE(near.all.motion.translation_m.mean());
  EXPECT_FALSE(near.all.distance_m.mean());
  EXPECT_EQ(near.all.covered_frames, 2U * kSceneFrames);
}

TEST(ObjectMetrics, MeasureNoMotionOfWhatWalks) {
  std::vector<ObjectFrame> scene = perfect_scene();
  for (ObjectFrame& frame : scene) {
    frame.truth[0].rigid = false;
  }
  const ObjectMetrics metrics = evaluated(scene);
  EXPECT_FALSE(metrics.all.motion.translation_m.mean());
  EXPECT_EQ(metrics.all.distance_m.count(), static_cast<std::size_t>(kSceneFrames));  // Object 2 alone.
  EXPECT_EQ(metrics.objects[0].errors.distance_m.count(), static_cast<std::size_t>(kSceneFrames));
}

TEST(ObjectMetrics, HaveNoDistanceFromAFewRows) {
  EXPECT_FALSE(evaluated(perfect_scene(4)).all.distance_m.mean());
  EXPECT_TRUE(evaluated(perfect_scene(5)).all.distance_m.mean());
}

TEST(ObjectMetrics, ShowAWrongCentreWhateverItsOrigin) {
  const ObjectMetrics metrics = evaluated(
      spoiled_scene([](TrackEstimate& estimate, int) { estimate.box.center_m += Eigen::Vector3d(0.3, 0.0, 0.4); }));
  EXPECT_NEAR(metrics.objects[0].errors.center_m.mean().value(), 0.5, 1e-9);
  EXPECT_NEAR(metrics.all.center_m.mean().value(), 0.25, 1e-9);
  EXPECT_NEAR(metrics.all.distance_m.max().value(), 0.0, 1e-12);
}

TEST(ObjectMetrics, ShowSpeedAndHeadingErrors) {
  const ObjectMetrics metrics = evaluated(spoiled_scene([](TrackEstimate& estimate, int frame) {
    estimate.velocity_mps *= 1.1;
    estimate.heading_rad += 2.0 * std::numbers::pi - 3.0 * kRadPerDeg;
    estimate.moving = frame >= 5;
  }));
  EXPECT_NEAR(metrics.all.speed_mps.mean().value(), 0.1 * kCarSpeed_mps, 1e-9);
  EXPECT_NEAR(metrics.all.heading_deg.mean().value(), 3.0, 1e-9);
  EXPECT_EQ(metrics.all.heading_deg.count(), 15U);
  EXPECT_EQ(metrics.all.moving_rows, 20U);
  EXPECT_EQ(metrics.all.found_moving_rows, 15U);
}

TEST(ObjectMetrics, ShowPeopleApartFromRigidObjects) {
  std::vector<ObjectFrame> scene = spoiled_scene([](TrackEstimate& estimate, int frame) {
    estimate.velocity_mps *= 0.9;
    estimate.moving = frame >= 5;
    estimate.box.center_m.x() += 0.3;
  });
  for (ObjectFrame& frame : scene) {
    for (TrueObject& object : frame.truth) {
      object.rigid = false;
    }
  }
  const ObjectErrors all = evaluated(scene).all;
  EXPECT_EQ(all.walking_rows, 20U);
  EXPECT_EQ(all.found_walking_rows, 15U);
  EXPECT_NEAR(all.walking_speed_mps.mean().value(), 0.1 * kCarSpeed_mps, 1e-9);
  EXPECT_NEAR(all.walking_distance_m.mean().value(), 0.3, 1e-9);
  EXPECT_EQ(all.moving_rows, 0U);
  EXPECT_EQ(all.speed_mps.count(), 0U);
}

TEST(ObjectMetrics, CountSwappedTracksAsOneSwitchEach) {
  std::vector<ObjectFrame> scene = perfect_scene();
  for (std::size_t i = 10; i < scene.size(); ++i) {
    std::swap(scene[i].tracks[0].track_id, scene[i].tracks[1].track_id);
  }
  const ObjectMetrics metrics = evaluated(scene);
  EXPECT_EQ(metrics.all.id_switches, 2U);
  EXPECT_EQ(metrics.all.missing_motions, 1U);
  EXPECT_THAT(metrics.objects[0].track_ids, ElementsAre(11, 12));
  EXPECT_EQ(metrics.all.covered_frames, 2U * kSceneFrames);
}

TEST(ObjectMetrics, CountAnInterruptionOnceItEnds) {
  std::vector<ObjectFrame> scene = perfect_scene();
  for (const std::size_t i : {3U, 4U, 19U}) {
    scene[i].similarity(0, 0) = 0.49;
  }
  const ObjectMetrics metrics = evaluated(scene);
  EXPECT_EQ(metrics.all.fragmentations, 1U);
  EXPECT_EQ(metrics.all.id_switches, 0U);
  EXPECT_EQ(metrics.objects[0].errors.matched_frames, 17U);
  // Meanwhile its last track represents it.
  EXPECT_EQ(metrics.objects[0].errors.covered_frames, 20U);
  EXPECT_EQ(metrics.objects[0].errors.motion.translation_m.count(), 19U);
}

TEST(ObjectMetrics, KeepAMatchThatIsStillValid) {
  std::vector<ObjectFrame> scene = perfect_scene();
  for (std::size_t i = 5; i < 8; ++i) {
    // A second track has the greater overlap for a while.
    scene[i].tracks.push_back(scene[i].tracks[0]);
    scene[i].tracks.back().track_id = 99;
    scene[i].similarity = Eigen::MatrixXd{{0.6, 0.0, 0.9}, {0.0, 0.9, 0.0}};
  }
  const ObjectMetrics metrics = evaluated(scene);
  EXPECT_EQ(metrics.all.id_switches, 0U);
  EXPECT_THAT(metrics.objects[0].track_ids, ElementsAre(11));
}

TEST(ObjectMetrics, GiveNoTrackToTwoObjects) {
  std::vector<ObjectFrame> scene = perfect_scene();
  // Track 11 switches from object 1 to object 2, whose own track ends: object 1 must not keep it.
  for (std::size_t i = 10; i < scene.size(); ++i) {
    scene[i].tracks.erase(scene[i].tracks.begin() + 1);
    scene[i].similarity = Eigen::MatrixXd{{0.0}, {0.9}};
  }
  const ObjectMetrics metrics = evaluated(scene);
  EXPECT_EQ(metrics.objects[0].errors.covered_frames, 10U);
  EXPECT_EQ(metrics.objects[1].errors.covered_frames, 20U);
  EXPECT_EQ(metrics.objects[1].errors.id_switches, 1U);
}

TEST(ObjectMetrics, AreNoneForAnEmptySequence) {
  const ObjectMetrics metrics = evaluated({});
  EXPECT_THAT(metrics.objects, IsEmpty());
  EXPECT_FALSE(metrics.all.motion.translation_m.mean());
}

TEST(ObjectMetrics, HandleFramesWithoutTruthOrTracks) {
  std::vector<ObjectFrame> scene = perfect_scene();
  scene[3].tracks.clear();
  scene[3].similarity = Eigen::MatrixXd(2, 0);
  scene[6].truth.clear();
  scene[6].similarity = Eigen::MatrixXd(0, 2);
  const ObjectMetrics metrics = evaluated(scene);
  EXPECT_EQ(metrics.objects[0].errors.visible_frames, 19U);
  EXPECT_EQ(metrics.objects[0].errors.covered_frames, 18U);
  EXPECT_EQ(metrics.objects[0].errors.fragmentations, 1U);
}

TEST(FalseMoving, NamesATrackOfAnObjectAtRest) {
  std::vector<ObjectFrame> scene = perfect_scene();
  for (const std::size_t i : {4U, 5U, 9U}) {
    scene[i].tracks[1].estimate->moving = true;
    scene[i].tracks[1].estimate->velocity_mps = {0.0, 0.0, 2.0};
  }
  const ObjectMetrics metrics = evaluated(scene);
  ASSERT_EQ(metrics.false_moving.size(), 1U);
  const FalseMovingTrack& track = metrics.false_moving[0];
  EXPECT_EQ(track.track_id, 12U);
  EXPECT_EQ(track.frames, 3U);
  EXPECT_EQ(track.first_frame, 4);
  EXPECT_EQ(track.last_frame, 9);
  EXPECT_NEAR(track.mean_speed_mps, 2.0, 1e-12);
  EXPECT_EQ(track.object_id, 2U);
}

TEST(FalseMoving, ForgivesTwoFramesAndLostOnes) {
  std::vector<ObjectFrame> scene = perfect_scene();
  for (const std::size_t i : {4U, 5U, 9U}) {
    scene[i].tracks[1].estimate->moving = true;
  }
  scene[9].tracks[1].estimate->status = BodyStatus::kLost;
  EXPECT_THAT(evaluated(scene).false_moving, IsEmpty());
}

std::vector<ObjectFrame> scene_with_a_phantom(int covers) {
  std::vector<ObjectFrame> scene = perfect_scene();
  for (ObjectFrame& frame : scene) {
    TrackInFrame phantom = frame.tracks[0];
    phantom.track_id = 50;
    phantom.covers = covers;
    frame.tracks.push_back(phantom);
    frame.similarity = Eigen::MatrixXd{{0.9, 0.0, 0.2}, {0.0, 0.9, 0.0}};
  }
  return scene;
}

TEST(FalseMoving, NamesATrackOfNothingIfTheTruthIsComplete) {
  const ObjectMetrics metrics = evaluated(scene_with_a_phantom(-1));
  ASSERT_EQ(metrics.false_moving.size(), 1U);
  EXPECT_EQ(metrics.false_moving[0].track_id, 50U);
  EXPECT_EQ(metrics.false_moving[0].frames, static_cast<std::size_t>(kSceneFrames));
  EXPECT_FALSE(metrics.false_moving[0].object_id);
  EXPECT_THAT(evaluated(scene_with_a_phantom(-1), {.truth_is_complete = false}).false_moving, IsEmpty());
}

TEST(FalseMoving, AcceptsAPartOfAMovingObject) {
  EXPECT_THAT(evaluated(scene_with_a_phantom(0)).false_moving, IsEmpty());
  EXPECT_EQ(evaluated(scene_with_a_phantom(1)).false_moving.size(), 1U);
}

TEST(FalseMoving, APredictedMaskOnAnotherObjectIsNoOtherObject) {
  // The moving object is hidden from frame 5 on, where its predicted mask lies on the one at rest.
  const auto false_moving = [](BodyStatus status) {
    std::vector<ObjectFrame> scene = scene_with_a_phantom(0);
    for (std::size_t i = 5; i < scene.size(); ++i) {
      scene[i].tracks[2].covers = 1;
      scene[i].tracks[2].estimate->status = status;
    }
    return evaluated(scene).false_moving.size();
  };
  EXPECT_EQ(false_moving(BodyStatus::kPropagated), 0U);
  EXPECT_EQ(false_moving(BodyStatus::kStereoOnly), 1U);
}

}  // namespace
}  // namespace kinetrace::evaluation

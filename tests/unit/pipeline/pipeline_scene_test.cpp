// The whole pipeline on rendered scenes with exact truth.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "kinetrace/core/detections.hpp"
#include "pipeline_run.hpp"

namespace kinetrace::pipeline {
namespace {

using segmentation::SegmentationMode;
using test::KeptEstimate;
using test::MaskFolder;
using test::Mover;
using test::PipelineRun;
using test::RenderedPair;
using test::small_config;
using test::small_rig;
using test::StreetDrive;

double rotation_error_deg(const Se3& a, const Se3& b) {
  return so3_log(a.rotation.transpose() * b.rotation).norm() * 57.29577951308232;
}

TEST(PipelineScene, CameraFollowsTheTruthAndNothingMovesInAStaticStreet) {
  PipelineRun run(small_config(SegmentationMode::kMotion));
  run.drive(StreetDrive(), 0, 24);
  run.drain();
  ASSERT_EQ(run.finalised.size(), 24U);
  for (const KeptEstimate& estimate : run.finalised) {
    const Se3 truth = StreetDrive::T_world_cam(static_cast<int>(estimate.frame_index));
    EXPECT_EQ(estimate.camera.status, BodyStatus::kTracked);
    EXPECT_GT(estimate.camera.inliers, 50);
    EXPECT_LT(rotation_error_deg(estimate.camera.T_world_cam, truth), 0.15) << "frame " << estimate.frame_index;
  }
  // Over a path of eleven metres.
  EXPECT_LT(test::worst_camera_error_m(run.finalised), 0.05);
  EXPECT_TRUE(test::object_ids(run.finalised).empty());
  EXPECT_EQ(run.counters.background_lost_frames, 0U);
}

TEST(PipelineScene, CameraIsWellWhereFramesAreMissing) {
  PipelineRun run(small_config());
  const StreetDrive street;
  for (const int frame : {0, 1, 2, 3, 4, 5, 7, 8, 10, 11, 12}) {
    run.step(street.render(frame).at(frame));
  }
  run.drain();
  EXPECT_LT(test::worst_camera_error_m(run.finalised), 0.05);
  EXPECT_EQ(run.counters.background_lost_frames, 0U);
}

/// Expects exactly one object, on the mover's path, up to the object frame, which is fixed at birth.
void expect_mover(const PipelineRun& run, const StreetDrive& street, int steady_from, double max_rotation_deg = 5.0) {
  const std::vector<std::uint32_t> ids = test::object_ids(run.finalised);
  ASSERT_EQ(ids.size(), 1U);
  const ObjectResult* first = nullptr;
  int first_frame = 0;
  int rows = 0;
  for (const KeptEstimate& estimate : run.finalised) {
    const ObjectResult* object = estimate.object(ids[0]);
    const int frame = static_cast<int>(estimate.frame_index);
    if (object == nullptr || frame < steady_from) {
      continue;
    }
    if (first == nullptr) {
      first = object;
      first_frame = frame;
    }
    ++rows;
    EXPECT_EQ(object->status, BodyStatus::kTracked) << "frame " << frame;
    EXPECT_TRUE(object->moving) << "frame " << frame;
    EXPECT_LT((object->velocity_mps - street.movers()[0].velocity_mps).norm(), 0.4)
        << "frame " << frame << ": " << object->velocity_mps.transpose();
    const Eigen::Vector3d went = object->T_world_obj.translation - first->T_world_obj.translation;
    const Eigen::Vector3d truth =
        street.T_world_mover(0, frame).translation - street.T_world_mover(0, first_frame).translation;
    EXPECT_LT((went - truth).norm(), 0.15) << "frame " << frame;
    EXPECT_LT(rotation_error_deg(object->T_world_obj, first->T_world_obj), max_rotation_deg) << "frame " << frame;
  }
  EXPECT_GE(rows, 12);
}

TEST(PipelineScene, MaskedBoxBecomesOneTrackWithItsVelocity) {
  const StreetDrive street({Mover{}});
  MaskFolder masks;
  for (int frame = 0; frame < 20; ++frame) {
    masks.write(street.render(frame), frame);
  }
  PipelineRun run(small_config(masks));
  run.drive(street, 0, 20);
  run.drain();
  expect_mover(run, street, 3);
  EXPECT_LT(test::worst_camera_error_m(run.finalised), 0.05);
  // The object is there from the frame of its birth on, once it is confirmed.
  EXPECT_EQ(run.finalised[0].objects.size(), 1U);
  EXPECT_EQ(run.newest[0].objects.size(), 0U);
  EXPECT_EQ(run.finalised[5].objects[0].class_id, kVehicleClass);
}

TEST(PipelineScene, MaskedBoxMayMoveAcrossTheView) {
  const StreetDrive street(
      {Mover{.size_m = {3.0, 2.2, 2.4}, .start_m = {-4.0, 0.4, 11.0}, .velocity_mps = {3.0, 0.0, 5.0}}});
  MaskFolder masks;
  for (int frame = 0; frame < 20; ++frame) {
    masks.write(street.render(frame), frame);
  }
  PipelineRun run(small_config(masks));
  run.drive(street, 0, 20);
  run.drain();
  expect_mover(run, street, 3);
}

TEST(PipelineScene, PeopleGetTheirPathFromStereoAlone) {
  const StreetDrive street(
      {Mover{.size_m = {0.7, 1.7, 0.5}, .start_m = {-2.0, 0.65, 9.0}, .velocity_mps = {1.2, 0.0, 4.0}}});
  MaskFolder masks;
  for (int frame = 0; frame < 20; ++frame) {
    masks.write(street.render(frame), frame, kPedestrianClass);
  }
  PipelineRun run(small_config(masks));
  run.drive(street, 0, 20);
  run.drain();
  ASSERT_EQ(test::object_ids(run.finalised).size(), 1U);
  for (const KeptEstimate& estimate : run.finalised) {
    ASSERT_EQ(estimate.objects.size(), 1U) << "frame " << estimate.frame_index;
    const ObjectResult& object = estimate.objects[0];
    EXPECT_EQ(object.class_id, kPedestrianClass);
    EXPECT_EQ(object.status, BodyStatus::kStereoOnly) << "frame " << estimate.frame_index;
    EXPECT_LT(
        (object.T_world_obj.translation - street.T_world_mover(0, static_cast<int>(estimate.frame_index)).translation)
            .norm(),
        0.6)
        << "frame " << estimate.frame_index;
    EXPECT_LT(std::sqrt(object.covariance.bottomRightCorner<3, 3>().trace()), 1.5);
  }
  const ObjectResult& middle = run.finalised[10].objects[0];
  EXPECT_TRUE(middle.moving);
  EXPECT_LT((middle.velocity_mps - street.movers()[0].velocity_mps).norm(), 0.5) << middle.velocity_mps.transpose();
}

TEST(PipelineScene, MovingBoxIsFoundWithoutMasks) {
  const StreetDrive street({Mover{.velocity_mps = {1.0, 0.0, 8.0}}});
  PipelineRun run(small_config(SegmentationMode::kMotion));
  run.drive(street, 0, 30);
  run.drain();
  // A region found by motion includes some ground beside the object, which rotates the estimate slowly.
  expect_mover(run, street, 14, 10.0);
  EXPECT_LT(test::worst_camera_error_m(run.finalised), 0.05);
}

TEST(PipelineScene, MissingMasksAreBridged) {
  const StreetDrive street({Mover{}});
  MaskFolder masks;
  for (int frame = 0; frame < 18; ++frame) {
    if (frame < 8 || frame > 11) {
      masks.write(street.render(frame), frame);
    }
  }
  PipelineRun run(small_config(masks));
  run.drive(street, 0, 18);
  run.drain();
  for (std::size_t frame = 8; frame <= 11; ++frame) {
    ASSERT_EQ(run.tracks[frame].size(), 1U) << "frame " << frame;
    EXPECT_EQ(run.tracks[frame][0].state, TrackState::kPropagated) << "frame " << frame;
  }
  EXPECT_EQ(run.tracks[12][0].state, TrackState::kConfirmed);
  EXPECT_EQ(run.counters.detection_frames_missing, 4U);
  expect_mover(run, street, 3);
}

/// Ten frames of the street, `blind` frames without texture, and the street again.
PipelineRun drive_with_blind_frames(const PipelineConfig& config, const StreetDrive& street, int blind,
                                    std::uint8_t gray) {
  PipelineRun run(config);
  run.drive(street, 0, 10);
  const RenderedPair blank = test::blank_pair(small_rig(), gray);
  for (int frame = 10; frame < 10 + blind; ++frame) {
    const std::string stem = test::stem_of(frame);
    run.step(blank.at(frame, stem));
  }
  run.drive(street, 10 + blind, 20 + blind);
  run.drain();
  return run;
}

TEST(PipelineScene, BlindFramesArePropagatedThenLostThenOvercome) {
  for (const std::uint8_t gray : {std::uint8_t{0}, std::uint8_t{128}, std::uint8_t{255}}) {
    const PipelineRun run = drive_with_blind_frames(small_config(), StreetDrive(), 5, gray);
    ASSERT_EQ(run.finalised.size(), 25U);
    EXPECT_EQ(run.finalised[9].camera.status, BodyStatus::kTracked);
    EXPECT_EQ(run.finalised[10].camera.status, BodyStatus::kPropagated);
    EXPECT_EQ(run.finalised[11].camera.status, BodyStatus::kPropagated);
    EXPECT_EQ(run.finalised[13].camera.status, BodyStatus::kLost);
    EXPECT_EQ(run.finalised[14].camera.status, BodyStatus::kLost);
    // The first frame with texture makes a new map; the next one is tracked on it.
    for (std::size_t frame = 16; frame < 25; ++frame) {
      EXPECT_EQ(run.finalised[frame].camera.status, BodyStatus::kTracked) << "frame " << frame;
    }
    EXPECT_EQ(run.counters.background_lost_frames, 6U);
    // The motion was extrapolated.
    EXPECT_LT(test::worst_camera_error_m(run.finalised), 0.3);
    // A pose that was only predicted is less sure than one that was measured.
    EXPECT_GT(run.finalised[14].camera.covariance.trace(), 10.0 * run.finalised[9].camera.covariance.trace());
  }
}

TEST(PipelineScene, ObjectsSurviveABlindFrame) {
  const StreetDrive street({Mover{}});
  MaskFolder masks;
  for (int frame = 0; frame < 21; ++frame) {
    if (frame != 10) {
      masks.write(street.render(frame), frame);
    }
  }
  const PipelineRun run = drive_with_blind_frames(small_config(masks), street, 1, 0);
  const std::vector<std::uint32_t> ids = test::object_ids(run.finalised);
  ASSERT_EQ(ids.size(), 1U);
  const ObjectResult* blind = run.finalised[10].object(ids[0]);
  ASSERT_NE(blind, nullptr);
  EXPECT_EQ(blind->status, BodyStatus::kPropagated);
  for (std::size_t frame = 14; frame < 21; ++frame) {
    const ObjectResult* object = run.finalised[frame].object(ids[0]);
    ASSERT_NE(object, nullptr) << "frame " << frame;
    EXPECT_EQ(object->status, BodyStatus::kTracked) << "frame " << frame;
    EXPECT_LT((object->velocity_mps - street.movers()[0].velocity_mps).norm(), 1.5) << "frame " << frame;
  }
}

TEST(PipelineScene, NothingToSeeFromTheStartIsNoError) {
  PipelineRun run(small_config(SegmentationMode::kMotion));
  const RenderedPair blank = test::blank_pair(small_rig(), 90);
  for (int frame = 0; frame < 8; ++frame) {
    run.step(blank.at(frame));
  }
  const StreetDrive street;
  run.drive(street, 8, 14);
  run.drain();
  ASSERT_EQ(run.finalised.size(), 14U);
  EXPECT_EQ(run.finalised[7].camera.status, BodyStatus::kLost);
  EXPECT_EQ(run.finalised[7].camera.T_world_cam.translation, Eigen::Vector3d::Zero());
  EXPECT_TRUE(test::object_ids(run.finalised).empty());
  for (std::size_t frame = 9; frame < 14; ++frame) {
    EXPECT_EQ(run.finalised[frame].camera.status, BodyStatus::kTracked) << "frame " << frame;
  }
}

/// Six boxes in two rows, all visible, all masked.
StreetDrive crowd() {
  std::vector<Mover> movers;
  for (const double row : {0.0, 1.0}) {
    for (const double column : {-1.0, 0.0, 1.0}) {
      movers.push_back({.size_m = {1.0, 1.2, 1.0},
                        .start_m = {2.8 * column, 0.9 - 1.6 * row, 9.0 + row},
                        .velocity_mps = {0.0, 0.0, 5.0}});
    }
  }
  return StreetDrive(movers);
}

TEST(PipelineScene, ObjectsBeyondTheCapacityAreDroppedAndCounted) {
  const StreetDrive street = crowd();
  MaskFolder masks;
  for (int frame = 0; frame < 10; ++frame) {
    masks.write(street.render(frame), frame);
  }
  for (const int capacity : {5, 6}) {
    PipelineConfig config = small_config(masks);
    config.tracking.max_objects = capacity;
    PipelineRun run(config);
    run.drive(street, 0, 10);
    run.drain();
    EXPECT_EQ(run.counters.detections, 60U);
    EXPECT_EQ(test::object_ids(run.finalised).size(), static_cast<std::size_t>(capacity));
    EXPECT_EQ(run.counters.detections_dropped, capacity == 6 ? 0U : 10U);
    for (const KeptEstimate& estimate : run.finalised) {
      EXPECT_LE(estimate.objects.size(), static_cast<std::size_t>(capacity));
      for (const ObjectResult& object : estimate.objects) {
        EXPECT_GE(object.label, 1);
        EXPECT_LE(object.label, capacity);
      }
    }
  }
}

TEST(PipelineScene, DetectionsBeyondTheSegmentersCapacityAreDroppedAndCounted) {
  const StreetDrive street = crowd();
  MaskFolder masks;
  for (int frame = 0; frame < 4; ++frame) {
    masks.write(street.render(frame), frame);
  }
  PipelineConfig config = small_config(masks);
  config.tracking.max_objects = 6;
  config.segmentation.max_objects = 2;
  PipelineRun run(config);
  run.drive(street, 0, 4);
  EXPECT_EQ(run.counters.detections, 8U);
  EXPECT_EQ(run.counters.detections_dropped, 2U * 4U * 4U) << "four too many, in both views, in four frames";
  EXPECT_EQ(run.tracks.back().size(), 2U);
}

TEST(PipelineScene, FeatureAndPointCapacitiesAreRespectedAndCounted) {
  PipelineConfig config = small_config();
  config.features.max_features = 60;
  config.features.max_background_features = 60;
  config.background.max_points = 40;
  PipelineRun run(config);
  const StreetDrive street;
  for (int frame = 0; frame < 10; ++frame) {
    const FrameResult& result = run.step(street.render(frame).at(frame));
    EXPECT_LE(result.bodies[0].points.size(), 40U);
  }
  EXPECT_GT(run.counters.features_dropped, 0U);
  EXPECT_GT(run.counters.points_dropped, 0U);
  run.drain();
  EXPECT_LT(test::worst_camera_error_m(run.finalised), 0.3);
}

}  // namespace
}  // namespace kinetrace::pipeline

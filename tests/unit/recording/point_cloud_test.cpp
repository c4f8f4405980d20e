// points/: PLY files read back and compared with the truth.
#include <algorithm>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "run_readers.hpp"
#include "synthetic_run.hpp"

namespace kinetrace::recording {
namespace {

using ::testing::ElementsAre;

TEST(PointClouds, BackgroundHoldsEachPointOnceInTheWorld) {
  const TemporaryFolder folder;
  ASSERT_TRUE(
      record_all(recording_config(folder.path()), {.frames = 20, .background_points = 10, .point_life_frames = 6}));
  const PlyFile ply = read_ply(folder.path() / "points/background.ply");
  EXPECT_EQ(ply.vertices.size(), 40U);  // Generations born at frames 0, 6, 12 and 18.
  std::set<std::uint32_t> ids;
  for (const PlyVertex& vertex : ply.vertices) {
    EXPECT_TRUE(ids.insert(vertex.point_id).second);
    EXPECT_TRUE(vertex.position_m.isApprox(SyntheticRun::point_position(0, vertex.point_id)));
    EXPECT_EQ(vertex.rgb[0], vertex.point_id % 256);
    EXPECT_EQ(vertex.rgb[2], vertex.rgb[0]);
    const int generation = static_cast<int>(vertex.point_id - 1) / 10;
    EXPECT_EQ(vertex.frame, std::min(19, generation * 6 + 6)) << "frame of retirement";
  }
}

TEST(PointClouds, PointsSeenInOneFrameOnlyAreLeftOut) {
  const TemporaryFolder folder;
  ASSERT_TRUE(
      record_all(recording_config(folder.path()), {.frames = 5, .background_points = 10, .point_life_frames = 1}));
  EXPECT_TRUE(read_ply(folder.path() / "points/background.ply").vertices.empty());
}

TEST(PointClouds, ObjectPointsFollowTheTrajectory) {
  const TemporaryFolder folder;
  ASSERT_TRUE(record_all(recording_config(folder.path()),
                         {.frames = 12, .objects = {{.track_id = 3, .first_frame = 2, .last_frame = 9, .points = 7}}}));
  const PlyFile model = read_ply(folder.path() / "points/object_3_model.ply");
  ASSERT_EQ(model.vertices.size(), 7U);
  for (const PlyVertex& vertex : model.vertices) {
    EXPECT_TRUE(vertex.position_m.isApprox(SyntheticRun::point_position(3, vertex.point_id)));
  }
  const PlyFile trajectory = read_ply(folder.path() / "points/object_3.ply");
  ASSERT_EQ(trajectory.vertices.size(), 7U * 8U) << "every point at every frame";
  std::set<std::pair<int, std::uint32_t>> pairs;
  for (const PlyVertex& vertex : trajectory.vertices) {
    EXPECT_TRUE(pairs.insert({vertex.frame, vertex.point_id}).second);
    const Eigen::Vector3d p_obj = SyntheticRun::point_position(3, vertex.point_id).cast<double>();
    const Eigen::Vector3d truth = SyntheticRun::T_world_obj(3, vertex.frame) * p_obj;
    EXPECT_LT((vertex.position_m.cast<double>() - truth).norm(), 1e-5);
  }
  EXPECT_EQ(pairs.begin()->first, 2);
  EXPECT_EQ(pairs.rbegin()->first, 9);
}

TEST(PointClouds, LongTrajectoriesAreThinnedByAStatedStride) {
  const TemporaryFolder folder;
  RecordingConfig recording = recording_config(folder.path());
  recording.max_trajectory_vertices = 30;  // 3 frames of 10 points; 10 frames need a stride of 4.
  ASSERT_TRUE(record_all(recording, {.frames = 10, .objects = {{.track_id = 3, .points = 10}}}));
  const PlyFile ply = read_ply(folder.path() / "points/object_3.ply");
  EXPECT_NE(ply.comment.find("frame_stride 4"), std::string::npos) << ply.comment;
  std::set<int> frames;
  for (const PlyVertex& vertex : ply.vertices) {
    frames.insert(vertex.frame);
  }
  EXPECT_EQ(frames, (std::set<int>{0, 4, 8}));
  EXPECT_EQ(ply.vertices.size(), 30U);
}

TEST(PointClouds, ThoseThatJustFitAreNotThinned) {
  const TemporaryFolder folder;
  RecordingConfig recording = recording_config(folder.path());
  recording.max_trajectory_vertices = 100;
  ASSERT_TRUE(record_all(recording, {.frames = 10, .objects = {{.track_id = 3, .points = 10}}}));
  const PlyFile ply = read_ply(folder.path() / "points/object_3.ply");
  EXPECT_NE(ply.comment.find("frame_stride 1"), std::string::npos) << ply.comment;
  EXPECT_EQ(ply.vertices.size(), 100U);
}

TEST(PointClouds, ObjectsWithoutAReconstructionHaveNoTrajectoryPoints) {
  const TemporaryFolder folder;
  ASSERT_TRUE(record_all(recording_config(folder.path()),
                         {.frames = 8,
                          .objects = {{.track_id = 1, .status = BodyStatus::kStereoOnly, .points = 0},
                                      {.track_id = 2, .status = BodyStatus::kPropagated},
                                      {.track_id = 3, .status = BodyStatus::kInitializing}}}));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "points/object_1.ply"));
  EXPECT_TRUE(read_ply(folder.path() / "points/object_2.ply").vertices.empty());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "points/object_3.ply")) << "never reported as an object";
}

/// One frame, finalised at once, whose background retires the given points.
FrameResult finalised_frame(int frame, std::span<const BodyGeometry> bodies) {
  FrameResult result;
  result.newest.frame_index = frame;
  result.newest.camera.status = BodyStatus::kTracked;
  result.has_finalised = true;
  result.finalised = result.newest;
  result.bodies = bodies;
  return result;
}

TEST(PointClouds, APointMadeAgainFromTheSameFeatureCountsInItsLastPosition) {
  const TemporaryFolder folder;
  RecorderFixture fixture(recording_config(folder.path()));
  ASSERT_TRUE(fixture.recorder);
  for (int frame = 0; frame < 3; ++frame) {
    const BodyPoint point{.id = 9, .position_m = {0.F, 0.F, 1.F + static_cast<float>(frame)}, .observations = 3};
    BodyGeometry background;
    background.retired = std::span(&point, 1);
    ASSERT_TRUE(fixture.recorder->record(finalised_frame(frame, std::span(&background, 1))));
  }
  ASSERT_TRUE(fixture.recorder->finish({}));
  const PlyFile ply = read_ply(folder.path() / "points/background.ply");
  ASSERT_EQ(ply.vertices.size(), 1U);
  EXPECT_EQ(ply.vertices[0].position_m.z(), 3.F);
  EXPECT_EQ(ply.vertices[0].frame, 2);
}

/// An object 10 m or 60 m ahead, 4.6 m from corner to corner of its box, with points up to 24 m behind it.
std::vector<float> kept_depths_m(double object_depth_m) {
  const TemporaryFolder folder;
  RecorderFixture fixture(recording_config(folder.path()));
  EXPECT_TRUE(fixture.recorder);
  std::vector<BodyPoint> points;
  for (const float z : {-2.F, 0.F, 2.F, 2.8F, 4.5F, 6.F, 24.F}) {
    points.push_back(
        {.id = static_cast<std::uint32_t>(points.size() + 1), .position_m = {0.F, 0.F, z}, .observations = 3});
  }
  ObjectResult object;
  object.track_id = 5;
  object.status = BodyStatus::kTracked;
  object.T_world_obj.translation.z() = object_depth_m;
  object.T_obj_cam.translation.z() = -object_depth_m;
  object.box = {{0.0, 0.0, object_depth_m}, {4.0, 1.5, 1.8}, 0.0};
  BodyGeometry body;
  body.track_id = 5;
  body.retired = points;
  FrameResult result = finalised_frame(0, std::span(&body, 1));
  result.finalised.objects = std::span(&object, 1);
  EXPECT_TRUE(fixture.recorder->record(result));
  EXPECT_TRUE(fixture.recorder->finish({}));
  std::vector<float> depths_m;
  for (const auto& vertex : read_ply(folder.path() / "points/object_5_model.ply").vertices) {
    depths_m.push_back(vertex.position_m.z());
  }
  const std::string left_out = "\"stray_points\": " + std::to_string(points.size() - depths_m.size());
  EXPECT_NE(read_text(folder.path() / "run.json").find(left_out), std::string::npos) << left_out;
  return depths_m;
}

TEST(PointClouds, PointsThatCannotBeTheirObjectsAreLeftOut) {
  EXPECT_THAT(kept_depths_m(10.0), ElementsAre(-2.F, 0.F, 2.F, 2.8F)) << "depth is certain to decimetres";
  EXPECT_THAT(kept_depths_m(60.0), ElementsAre(-2.F, 0.F, 2.F, 2.8F, 4.5F)) << "certain to no more than its length";
}

}  // namespace
}  // namespace kinetrace::recording

// colmap/: text models read back strictly; references must exist in both directions, and every point must reproject.
#include <cmath>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "run_readers.hpp"
#include "synthetic_run.hpp"

namespace kinetrace::recording {
namespace {

RecordingConfig rectified_recording(const std::filesystem::path& directory) {
  RecordingConfig config = recording_config(directory);
  config.is_rectified = true;
  return config;
}

/// Largest distance between an observation and its point seen through the model's own camera: catches a wrong direction
/// of the poses, a shifted pixel origin and mixed-up ids at once.
double largest_reprojection_error_px(const ColmapModel& model) {
  const auto& [width, height, fx, fy, cx, cy] = model.camera;
  double largest = 0.0;
  for (const auto& [id, image] : model.images) {
    for (std::size_t i = 0; i < image.point_ids.size(); ++i) {
      if (image.point_ids[i] < 0) {
        continue;
      }
      const Eigen::Vector3d p_cam = image.T_cam_body * model.points.at(image.point_ids[i]).position_m;
      const Eigen::Vector2d seen(fx * p_cam.x() / p_cam.z() + cx, fy * p_cam.y() / p_cam.z() + cy);
      largest = std::max(largest, (seen - image.points_px[i]).norm());
    }
  }
  return largest;
}

TEST(ColmapModel, BackgroundAndObjectsReproject) {
  const TemporaryFolder folder;
  ASSERT_TRUE(record_all(recording_config(folder.path()),
                         {.frames = 20,
                          .background_points = 25,
                          .objects = {{.track_id = 2, .first_frame = 3, .last_frame = 12, .points = 9},
                                      {.track_id = 1500, .first_frame = 5, .points = 4}}}));
  for (const auto& [name, images, points] :
       {std::tuple{"background", 20U, 100U}, std::tuple{"object_2", 10U, 9U}, std::tuple{"object_1500", 15U, 4U}}) {
    const ColmapModel model = read_colmap(folder.path() / "colmap" / name);
    EXPECT_EQ(model.images.size(), images) << name;
    EXPECT_EQ(model.points.size(), points) << name;
    EXPECT_LT(largest_reprojection_error_px(model), 2e-3) << name;
  }
}

TEST(ColmapModel, CameraIsTheLeftOneWithColmapsPixelOrigin) {
  const TemporaryFolder folder;
  ASSERT_TRUE(record_all(rectified_recording(folder.path()), {.frames = 3}));
  const ColmapModel model = read_colmap(folder.path() / "colmap/background");
  const std::array<double, 6> expected{320.0, 120.0, 200.0, 210.0, 161.75, 59.0};
  EXPECT_EQ(model.camera, expected);
  ASSERT_EQ(model.images.size(), 3U);
  EXPECT_EQ(model.images.at(1).name, "0000000000.png");
  EXPECT_EQ(model.images.at(3).name, "0000000002.png");
  EXPECT_LT(left_difference(model.images.at(3).T_cam_body, SyntheticRun::T_world_cam(2).inverse()).norm(), 1e-8);
  EXPECT_EQ(model.points.begin()->second.gray, 1);
  EXPECT_EQ(model.points.begin()->second.error_px, 0.25);
}

TEST(ColmapModel, ImagesKeepTheirRecordedNames) {
  const TemporaryFolder folder;
  ASSERT_TRUE(record_all(rectified_recording(folder.path()),
                         {.frames = 9, .objects = {{.track_id = 1, .first_frame = 4}}, .name_prefix = "left_"}));
  const ColmapModel model = read_colmap(folder.path() / "colmap/background");
  EXPECT_EQ(model.images.at(1).name, "left_0.png");
  EXPECT_EQ(model.images.at(9).name, "left_8.png");
  EXPECT_EQ(read_colmap(folder.path() / "colmap/object_1").images.at(5).name, "left_4.png");
}

TEST(ColmapModel, NamesThatWouldBreakTheFileGiveWayToNumbers) {
  const TemporaryFolder folder;
  ASSERT_TRUE(record_all(rectified_recording(folder.path()), {.frames = 2, .name_prefix = "with space "}));
  EXPECT_EQ(read_colmap(folder.path() / "colmap/background").images.at(2).name, "0000000001.png");
  const TemporaryFolder other;
  ASSERT_TRUE(record_all(rectified_recording(other.path()), {.frames = 2, .name_prefix = std::string(80, 'x')}));
  EXPECT_EQ(read_colmap(other.path() / "colmap/background").images.at(2).name, "0000000001.png");
}

/// COLMAP accepts one image per name.
TEST(ColmapModel, FramesOfARecordingThatIsPlayedAgainAreNamedByTheirNumbers) {
  const TemporaryFolder folder;
  RecordingConfig config = rectified_recording(folder.path());
  config.repeats = true;
  ASSERT_TRUE(record_all(config, {.frames = 2, .name_prefix = "left_"}));
  const ColmapModel model = read_colmap(folder.path() / "colmap/background");
  EXPECT_EQ(model.images.at(1).name, "0000000000_rectified.png");
  EXPECT_EQ(model.images.at(2).name, "0000000001_rectified.png");
  EXPECT_NE(read_text(folder.path() / "colmap/background/cameras.txt").find("`kinetrace run --images` writes them"),
            std::string::npos);
}

/// The names of raw images would attribute the model to them, whose camera differs.
TEST(ColmapModel, NamesNoImageThatItIsNotOf) {
  const TemporaryFolder folder;
  ASSERT_TRUE(record_all(recording_config(folder.path()), {.frames = 3, .name_prefix = "left_"}));
  EXPECT_EQ(read_colmap(folder.path() / "colmap/background").images.at(1).name, "left_0_rectified.png");
  EXPECT_NE(read_text(folder.path() / "colmap/background/cameras.txt").find("`kinetrace run --images` writes them"),
            std::string::npos);
}

TEST(ColmapModel, OnlyFramesWithAPoseOfTheirOwnAreImages) {
  const TemporaryFolder folder;
  ASSERT_TRUE(
      record_all(recording_config(folder.path()),
                 {.frames = 9, .objects = {{.track_id = 1, .status = BodyStatus::kPropagated}, {.track_id = 2}}}));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "colmap/object_1"));
  EXPECT_EQ(read_colmap(folder.path() / "colmap/object_2").images.size(), 9U);
}

TEST(ColmapModel, PointsThatNeverRetireLeaveNoTrace) {
  const TemporaryFolder folder;
  RecorderFixture fixture(recording_config(folder.path()));
  ASSERT_TRUE(fixture.recorder);
  SyntheticRun run({.frames = 30, .settling_lag = 0, .background_points = 10, .point_life_frames = 6});
  for (int frame = 0; frame < 29; ++frame) {  // The last result, which retires all living points, is not recorded.
    ASSERT_TRUE(fixture.recorder->record(*run.next()));
  }
  ASSERT_TRUE(fixture.recorder->finish({}));
  const ColmapModel model = read_colmap(folder.path() / "colmap/background");
  EXPECT_EQ(model.points.size(), 40U);
  EXPECT_EQ(model.images.size(), 29U);
  const std::vector<std::int64_t>& last = model.images.at(29).point_ids;
  EXPECT_EQ(last, std::vector<std::int64_t>(10, -1)) << "seen, but without a final position";
}

/// Much more than the 64 KiB of working memory: runs of the external sort are merged twice.
TEST(ColmapModel, LongRunsAreConvertedInLittleMemory) {
  const TemporaryFolder folder;
  RecordingConfig recording = recording_config(folder.path());
  recording.conversion_kib = 64;
  ASSERT_TRUE(
      record_all(recording, {.frames = 700,
                             .background_points = 90,
                             .point_life_frames = 11,
                             .objects = {{.track_id = 1, .first_frame = 100, .last_frame = 400, .points = 20},
                                         {.track_id = 7, .first_frame = 300, .last_frame = 650, .points = 12}}}));
  const ColmapModel background = read_colmap(folder.path() / "colmap/background");
  EXPECT_EQ(background.images.size(), 700U);
  // 63 generations of 11 frames and one of 7.
  EXPECT_EQ(background.points.size(), 64U * 90U);
  EXPECT_LT(largest_reprojection_error_px(background), 2e-3);
  const ColmapModel object = read_colmap(folder.path() / "colmap/object_7");
  EXPECT_EQ(object.images.size(), 351U);
  EXPECT_EQ(object.points.size(), 12U);
  EXPECT_LT(largest_reprojection_error_px(object), 2e-3);
}

TEST(ColmapModel, IsWrittenWithoutAnyFrame) {
  const TemporaryFolder folder;
  ASSERT_TRUE(record_all(recording_config(folder.path()), {.frames = 0}));
  const ColmapModel model = read_colmap(folder.path() / "colmap/background");
  EXPECT_TRUE(model.images.empty());
  EXPECT_TRUE(model.points.empty());
}

}  // namespace
}  // namespace kinetrace::recording

// A recorded run with exact observations and inexact poses: refinement finds the truth.
#include <filesystem>
#include <set>

#include <gtest/gtest.h>

#include "camera_refinement.hpp"
#include "kinetrace/recording/observations.hpp"
#include "object_history.hpp"
#include "object_refinement.hpp"
#include "refined_run.hpp"
#include "synthetic_run.hpp"

namespace kinetrace::batch {
namespace {

using recording::SyntheticRun;

constexpr int kFrames = 40;
const AdjustmentOptions kOptions{.threads = 1, .keep_going = [] { return true; }};

class RunRefinement : public ::testing::Test {
 protected:
  void SetUp() override {
    recording::SyntheticRunConfig config;
    config.frames = kFrames;
    config.point_life_frames = kFrames;  // Otherwise all points change at once and leave frames unconnected.
    config.objects = {{.track_id = 3, .first_frame = 5, .points = 12}};
    config.name_prefix = "image_";
    ASSERT_TRUE(recording::record_all(recording::recording_config(folder_.path() / "run"), config));
  }

  /// The run, with drift and jitter of the path.
  [[nodiscard]] recording::Run disturbed() const {
    Result<recording::Run> run = recording::read_run(folder_.path() / "run");
    EXPECT_TRUE(run) << run.error().message;
    for (recording::CameraRow& row : run->camera) {
      row.T_world_cam = row.T_world_cam * error(row.frame);
    }
    for (recording::ObjectRow& row : run->objects) {
      row.T_world_obj = row.T_world_obj * error(row.frame + 7);
      row.box.center_m =
          row.T_world_obj * (SyntheticRun::T_world_obj(3, static_cast<int>(row.frame)).inverse() * row.box.center_m);
    }
    return *run;
  }
  static Se3 error(std::int64_t frame) {
    const auto k = static_cast<double>(frame);
    return frame == 0 ? Se3{}
                      : Se3{so3_exp({0.0, 0.002 * std::sin(k), 0.0}), {0.05 * std::cos(3.0 * k), 0.0, 0.002 * k}};
  }
  /// Errors of frame-to-frame steps: absolute positions are weakly observable, all points are 50 to 70 m away.
  static double largest_step_error_m(const std::vector<Se3>& T_world_cam) {
    double largest_m = 0.0;
    for (std::size_t k = 1; k < T_world_cam.size(); ++k) {
      const int frame = static_cast<int>(k);
      const Se3 truth = SyntheticRun::T_world_cam(frame - 1).inverse() * SyntheticRun::T_world_cam(frame);
      const Se3 step = T_world_cam[k - 1].inverse() * T_world_cam[k];
      largest_m = std::max(largest_m, (step.translation - truth.translation).norm());
    }
    return largest_m;
  }
  static std::vector<Se3> path_of(const recording::Run& run) {
    std::vector<Se3> T_world_cam;
    for (const recording::CameraRow& row : run.camera) {
      T_world_cam.push_back(row.T_world_cam);
    }
    return T_world_cam;
  }

  recording::TemporaryFolder folder_;
};

TEST_F(RunRefinement, FindsTheCamerasPath) {
  const recording::Run run = disturbed();
  std::size_t rows_done = 0;
  const auto camera = refine_camera(run, {}, kOptions, [&](std::size_t rows) { rows_done = rows; });
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_EQ(rows_done, std::size_t{kFrames});
  EXPECT_LT(largest_step_error_m(camera->T_world_cam), 0.4 * largest_step_error_m(path_of(run)));
  std::set<std::uint32_t> ids;
  for (const RefinedPoint& point : camera->points) {
    EXPECT_TRUE(ids.insert(point.id).second) << "point " << point.id << " is there twice";
    EXPECT_LT(point.error_px, 0.1);
  }
  EXPECT_EQ(ids.size(), 30U);
}

TEST_F(RunRefinement, LeavesThePathAsItWasWhereItIsStopped) {
  const recording::Run run = disturbed();
  AdjustmentOptions stopped = kOptions;
  stopped.keep_going = [] { return false; };
  const auto camera = refine_camera(run, {}, stopped, [](std::size_t) {});
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_EQ(camera->T_world_cam.size(), run.camera.size());
}

TEST_F(RunRefinement, FindsAnObjectsPath) {
  const recording::Run run = disturbed();
  const auto histories = object_histories(run);
  ASSERT_TRUE(histories) << histories.error().message;
  std::vector<Se3> T_world_cam;
  T_world_cam.reserve(kFrames);
  for (int k = 0; k < kFrames; ++k) {
    T_world_cam.push_back(SyntheticRun::T_world_cam(k));
  }
  const auto object = refine_object(run, T_world_cam, histories->at(3), kOptions);
  ASSERT_TRUE(object) << object.error().message;
  ASSERT_EQ(object->frames.size(), std::size_t{kFrames - 5});
  // The object's frame follows the most certain row, so paths are compared from one frame to the next.
  for (int k = 6; k < kFrames; ++k) {
    const Se3 moved = object->frames.at(static_cast<std::size_t>(k)).row.T_world_obj *
                      object->frames.at(static_cast<std::size_t>(k - 1)).row.T_world_obj.inverse();
    const Se3 truth = SyntheticRun::T_world_obj(3, k) * SyntheticRun::T_world_obj(3, k - 1).inverse();
    const Eigen::Vector3d center_m = SyntheticRun::T_world_obj(3, k - 1).translation;
    EXPECT_LT((moved * center_m - truth * center_m).norm(), 0.01) << k;
  }
}

TEST_F(RunRefinement, SeesObjectsWithTheRightCameraThatTheBackgroundWasMeasuredWith) {
  constexpr float kChange_px = 0.5F;
  const recording::Run run = disturbed();
  const auto as_it_was = object_histories(run);
  ASSERT_TRUE(as_it_was) << as_it_was.error().message;
  std::vector<std::size_t> rows_seen;
  rows_seen.reserve(as_it_was->at(3).seen.size());
  for (const auto& [row, seen] : as_it_was->at(3).seen) {
    if (as_it_was->at(3).rows.contains(row)) {
      rows_seen.push_back(row);
    }
  }
  ASSERT_GT(rows_seen.size(), 1U) << as_it_was->at(3).seen.size() << " seen, " << as_it_was->at(3).rows.size();
  const std::size_t unchanged = rows_seen[0];
  const std::size_t changed = rows_seen[1];
  const std::int64_t frame = run.camera[changed].frame;
  std::vector<recording::Observation> before;
  before.reserve(50);
  for (int i = 0; i < 50; ++i) {
    before.push_back({.frame = static_cast<std::int32_t>(frame),
                      .u_left_px = 20.F * static_cast<float>(i % 10),
                      .v_px = 20.F * static_cast<float>(i) / 10.F,
                      .u_right_px = 20.F * static_cast<float>(i % 10) - 8.F});
  }
  std::vector<recording::Observation> now = before;
  for (recording::Observation& each : now) {
    each.u_right_px -= kChange_px;
  }
  MeasuredBackground measured;
  measured.frames.emplace(frame, now);
  measured.changes.emplace(frame, DisparityChange::between(run.rectified, before, now));
  const auto revised = object_histories(run, measured);
  ASSERT_TRUE(revised) << revised.error().message;
  for (const std::size_t row : {unchanged, changed}) {
    const float expected_px = row == changed ? kChange_px : 0.F;
    const SeenPoint& old_view = as_it_was->at(3).seen.at(row).front();
    const SeenPoint& view = revised->at(3).seen.at(row).front();
    EXPECT_NEAR(old_view.px.z() - view.px.z(), expected_px, 1e-3F);
    EXPECT_EQ(old_view.px.x(), view.px.x());
    const Se3 T_cam_world = run.camera[row].T_world_cam.inverse();
    const auto disparity_px = [&](const ObjectHistory& history) {
      return run.rectified.disparity_px((T_cam_world * history.rows.at(row).T_world_obj.translation).z());
    };
    EXPECT_NEAR(disparity_px(revised->at(3)) - disparity_px(as_it_was->at(3)), expected_px, 1e-3F);
  }
}

TEST_F(RunRefinement, DoesNotTakeForRestWhatTheRunHadNotYetSeenToMove) {
  recording::Run run = disturbed();
  auto histories = object_histories(run);
  ASSERT_TRUE(histories) << histories.error().message;
  ObjectHistory& history = histories->at(3);
  history.seen.clear();
  for (auto& [row, object] : history.rows) {
    object.status = BodyStatus::kStereoOnly;
    object.T_world_obj = SyntheticRun::T_world_obj(3, static_cast<int>(row));
    object.variances.setConstant(0.01);
    object.moving = row >= 15;
  }
  std::vector<Se3> T_world_cam;
  T_world_cam.reserve(kFrames);
  for (int k = 0; k < kFrames; ++k) {
    T_world_cam.push_back(SyntheticRun::T_world_cam(k));
  }
  const auto object = refine_object(run, T_world_cam, history, kOptions);
  ASSERT_TRUE(object) << object.error().message;
  for (int k = 6; k < kFrames; ++k) {
    const Eigen::Vector3d step_m = object->frames.at(static_cast<std::size_t>(k)).row.T_world_obj.translation -
                                   object->frames.at(static_cast<std::size_t>(k - 1)).row.T_world_obj.translation;
    const Eigen::Vector3d true_m =
        SyntheticRun::T_world_obj(3, k).translation - SyntheticRun::T_world_obj(3, k - 1).translation;
    EXPECT_LT((step_m - true_m).norm(), 0.02) << k;
  }
}

TEST_F(RunRefinement, IsWrittenAsARunThatCanBeReadAndRefinedAgain) {
  const recording::Run run = disturbed();
  RefinedRun refined;
  auto camera = refine_camera(run, {}, kOptions, [](std::size_t) {});
  ASSERT_TRUE(camera);
  refined.camera = std::move(*camera);
  const auto histories = object_histories(run);
  ASSERT_TRUE(histories) << histories.error().message;
  for (const auto& [track_id, history] : *histories) {
    refined.objects.emplace(track_id, *refine_object(run, refined.camera.T_world_cam, history, kOptions));
  }
  const Status written = write_refined_run(run, refined, folder_.path() / "refined", {}, [](std::size_t) {});
  ASSERT_TRUE(written) << written.error().message;
  const auto again = recording::read_run(folder_.path() / "refined");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_TRUE(again->is_finished);
  EXPECT_EQ(again->camera.size(), run.camera.size());
  EXPECT_EQ(again->objects.size(), run.objects.size());
  EXPECT_EQ(again->observation_rows, run.observation_rows);
  for (const char* file : {"mots.txt", "points/background.ply", "points/object_3_model.ply",
                           "colmap/background/points3D.txt", "colmap/object_3/images.txt"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / "refined" / file)) << file;
  }
  EXPECT_EQ(std::filesystem::file_size(folder_.path() / "refined" / "mots.txt"),
            std::filesystem::file_size(folder_.path() / "run" / "mots.txt"));
  EXPECT_TRUE(refine_camera(*again, {}, kOptions, [](std::size_t) {}));
}

}  // namespace
}  // namespace kinetrace::batch

// Guarantees of frame processing for any images: errors, order of results, data published once.
#include <algorithm>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline_run.hpp"

namespace kinetrace::pipeline {
namespace {

using segmentation::SegmentationMode;
using test::KeptEstimate;
using test::KeptPoints;
using test::MaskFolder;
using test::PipelineRun;
using test::PointKey;
using test::RenderedPair;
using test::small_config;
using test::small_rig;
using test::StreetDrive;

constexpr int kWindow = 5;

PipelineConfig short_window(PipelineConfig config) {
  config.background.window_frames = kWindow;
  config.object.window_frames = kWindow;
  return config;
}

TEST(Pipeline, RefusesImagesOfAnotherSize) {
  PipelineRun run(small_config());
  StereoGeometry other = small_rig();
  other.height_px -= 2;
  const RenderedPair wrong = test::blank_pair(other, 100);
  const RenderedPair right = test::blank_pair(small_rig(), 100);
  RectifiedPair right_view_wrong = right.at(7);
  right_view_wrong.right = wrong.view(wrong.right);
  for (const RectifiedPair& pair : {wrong.at(7), right_view_wrong}) {
    const auto result = run.pipeline().process(pair);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(result.error().message,
                ::testing::AllOf(::testing::HasSubstr("frame 7"), ::testing::HasSubstr("480x158"),
                                 ::testing::HasSubstr("480x160")));
  }
  EXPECT_TRUE(run.pipeline().process(right.at(7)));
}

TEST(Pipeline, RefusesTimeThatDoesNotAdvanceAndContinues) {
  PipelineRun run(small_config());
  const StreetDrive street;
  run.drive(street, 0, 3);
  for (const std::int64_t index : {2, 1}) {
    const auto result = run.pipeline().process(street.render(2).at(index));
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(result.error().message, ::testing::HasSubstr("frame " + std::to_string(index)));
  }
  run.drive(street, 3, 6);
  run.drain();
  EXPECT_EQ(run.finalised.size(), 6U);
  EXPECT_EQ(run.counters.frames, 6U);
  EXPECT_LT(test::worst_camera_error_m(run.finalised), 0.05);
}

TEST(Pipeline, DrainedWithoutAFrameGivesNothing) {
  PipelineRun run(small_config());
  EXPECT_EQ(run.pipeline().drain(), nullptr);
  EXPECT_EQ(run.pipeline().drain(), nullptr);
}

TEST(Pipeline, TakesNoFrameAfterDraining) {
  PipelineRun run(small_config());
  run.drive(StreetDrive(), 0, 2);
  run.drain();
  const auto result = run.pipeline().process(test::blank_pair(small_rig(), 100).at(9));
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kIllegalState);
  EXPECT_EQ(run.pipeline().drain(), nullptr);
}

TEST(Pipeline, FinalisesAFrameOnceItHasLeftTheWindow) {
  PipelineRun run(short_window(small_config()));
  const StreetDrive street;
  for (int frame = 0; frame < kWindow + 4; ++frame) {
    const FrameResult& result = run.step(street.render(frame).at(frame));
    EXPECT_EQ(result.newest.frame_index, frame);
    EXPECT_EQ(result.has_finalised, frame >= kWindow);
    if (result.has_finalised) {
      EXPECT_EQ(result.finalised.frame_index, frame - kWindow);
    }
  }
}

TEST(Pipeline, FinalisesEveryFrameOnceAndInOrderOfTime) {
  // Fewer frames than the window, as many, one more, and several more.
  for (const int frames : {1, kWindow - 1, kWindow, kWindow + 1, kWindow + 2, kWindow + 7}) {
    PipelineRun run(short_window(small_config()));
    run.drive(StreetDrive(), 0, frames);
    EXPECT_EQ(static_cast<int>(run.finalised.size()), std::max(0, frames - kWindow));
    run.drain();
    ASSERT_EQ(static_cast<int>(run.finalised.size()), frames);
    for (int frame = 0; frame < frames; ++frame) {
      const KeptEstimate& estimate = run.finalised[static_cast<std::size_t>(frame)];
      EXPECT_EQ(estimate.frame_index, frame);
      EXPECT_EQ(estimate.timestamp_ns, frame * 100'000'000LL);
      EXPECT_EQ(estimate.camera.status, BodyStatus::kTracked);
    }
  }
}

TEST(Pipeline, DrainingRepeatsTheNewestFrameAndShowsNoImages) {
  PipelineRun run(short_window(small_config()));
  run.drive(StreetDrive(), 0, 3);
  int given = 0;
  while (const FrameResult* result = run.pipeline().drain()) {
    EXPECT_TRUE(result->has_finalised);
    EXPECT_EQ(result->newest.frame_index, 2);
    EXPECT_TRUE(result->pair.left.empty());
    EXPECT_TRUE(result->pair.right.empty());
    EXPECT_TRUE(result->left_labels.empty());
    EXPECT_TRUE(result->tracks.empty());
    ++given;
  }
  EXPECT_EQ(given, 3);
}

/// A drive with one object whose masks stop half way, so that a track ends too.
class EndingTrack : public ::testing::Test {
 protected:
  static constexpr int kFrames = 16;
  static constexpr int kLastDetected = 8;

  EndingTrack() {
    for (int frame = 0; frame < kFrames; ++frame) {
      RenderedPair pair = street_.render(frame);
      if (frame > kLastDetected) {
        std::fill(pair.left_labels.begin(), pair.left_labels.end(), kBackgroundLabel);
        std::fill(pair.right_labels.begin(), pair.right_labels.end(), kBackgroundLabel);
      }
      masks_.write(pair, frame);
    }
    PipelineConfig config = short_window(small_config(masks_));
    config.tracking.max_missed_s = 0.2;
    config.tracking.max_unseen_s = 0.2;
    run_ = std::make_unique<PipelineRun>(config);
    run_->drive(street_, 0, kFrames);
    run_->drain();
  }

  StreetDrive street_{{test::Mover{}}};
  MaskFolder masks_;
  std::unique_ptr<PipelineRun> run_;
};

TEST_F(EndingTrack, IsCountedFromBirthToEnd) {
  EXPECT_EQ(run_->counters.tracks_born, 1U);
  EXPECT_EQ(run_->counters.tracks_confirmed, 1U);
  EXPECT_EQ(run_->counters.tracks_ended, 1U);
  EXPECT_EQ(run_->counters.frames, static_cast<std::uint64_t>(kFrames));
}

TEST_F(EndingTrack, HasRowsOnlyForFramesInWhichItLives) {
  int rows = 0;
  for (std::size_t frame = 0; frame < run_->newest.size(); ++frame) {
    const auto alive = [&](const ObjectResult& object) {
      return std::any_of(run_->tracks[frame].begin(), run_->tracks[frame].end(),
                         [&](const Track& track) { return track.id == object.track_id; });
    };
    for (const ObjectResult& object : run_->newest[frame].objects) {
      EXPECT_TRUE(alive(object)) << "newest, frame " << frame;
    }
    for (const ObjectResult& object : run_->finalised[frame].objects) {
      EXPECT_TRUE(alive(object)) << "finalised, frame " << frame;
      ++rows;
    }
  }
  EXPECT_GE(rows, kLastDetected);
}

TEST_F(EndingTrack, IsNearWhereCameraAndReconstructionPutIt) {
  for (const KeptEstimate& estimate : run_->finalised) {
    for (const ObjectResult& object : estimate.objects) {
      const Se3 composed = estimate.camera.T_world_cam * object.T_obj_cam.inverse();
      EXPECT_NEAR((composed.translation - object.T_world_obj.translation).norm(), 0.0, 0.1)
          << "frame " << estimate.frame_index;
      EXPECT_NEAR((composed.rotation - object.T_world_obj.rotation).norm(), 0.0, 0.03)
          << "frame " << estimate.frame_index;
    }
  }
}

TEST_F(EndingTrack, RetiresPointsWhenTheyLeaveTheMap) {
  std::size_t vanished = 0;
  std::size_t retired = 0;
  bool of_object = false;
  for (std::size_t frame = 1; frame < run_->points.size(); ++frame) {
    const KeptPoints& now = run_->points[frame];
    const std::set<PointKey> live(now.live.begin(), now.live.end());
    const std::set<PointKey> gone(now.retired.begin(), now.retired.end());
    EXPECT_EQ(gone.size(), now.retired.size()) << "a point twice in frame " << frame;
    for (const PointKey& point : gone) {
      EXPECT_EQ(live.count(point), 0U) << "both retired and alive in frame " << frame;
      of_object = of_object || point.first != 0;
    }
    for (const PointKey& point : run_->points[frame - 1].live) {
      vanished += live.count(point) == 0 ? 1U : 0U;
      retired += live.count(point) == 0 && gone.count(point) == 1 ? 1U : 0U;
    }
  }
  EXPECT_TRUE(of_object);
  EXPECT_GT(retired, 100U);
  // The others were culled as wrong.
  EXPECT_LE(vanished - retired, run_->counters.points_culled);
}

TEST_F(EndingTrack, RetiresWhatIsAliveAtTheEndWhileDraining) {
  std::vector<PointKey> alive = run_->points.back().live;
  std::sort(alive.begin(), alive.end());
  std::sort(run_->drained.begin(), run_->drained.end());
  EXPECT_GT(alive.size(), 50U);
  EXPECT_EQ(run_->drained, alive);
}

TEST(Pipeline, GivesTheSameResultsBitForBit) {
  const StreetDrive street({test::Mover{}});
  std::vector<PipelineRun> runs;
  for (int i = 0; i < 2; ++i) {
    PipelineRun& run = runs.emplace_back(short_window(small_config(SegmentationMode::kMotion)));
    run.drive(street, 0, 12);
    run.drain();
  }
  ASSERT_EQ(runs[0].finalised.size(), runs[1].finalised.size());
  std::size_t objects = 0;
  for (std::size_t i = 0; i < runs[0].finalised.size(); ++i) {
    const KeptEstimate& a = runs[0].finalised[i];
    const KeptEstimate& b = runs[1].finalised[i];
    EXPECT_EQ(a.camera.T_world_cam.rotation, b.camera.T_world_cam.rotation);
    EXPECT_EQ(a.camera.T_world_cam.translation, b.camera.T_world_cam.translation);
    EXPECT_EQ(a.camera.covariance, b.camera.covariance);
    ASSERT_EQ(a.objects.size(), b.objects.size());
    for (std::size_t k = 0; k < a.objects.size(); ++k, ++objects) {
      EXPECT_EQ(a.objects[k].track_id, b.objects[k].track_id);
      EXPECT_EQ(a.objects[k].T_world_obj.rotation, b.objects[k].T_world_obj.rotation);
      EXPECT_EQ(a.objects[k].T_world_obj.translation, b.objects[k].T_world_obj.translation);
      EXPECT_EQ(a.objects[k].velocity_mps, b.objects[k].velocity_mps);
      EXPECT_EQ(a.objects[k].covariance, b.objects[k].covariance);
    }
  }
  EXPECT_GT(objects, 0U);
}

}  // namespace
}  // namespace kinetrace::pipeline

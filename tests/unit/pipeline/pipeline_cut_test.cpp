// Frames that show another scene than those before, as when a recording restarts or has been cut.
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "camera/cut_detector.hpp"
#include "pipeline_run.hpp"

namespace kinetrace::pipeline {
namespace {

using test::KeptEstimate;
using test::MaskFolder;
using test::Mover;
using test::PipelineRun;
using test::RenderedPair;
using test::small_config;
using test::small_rig;
using test::StreetDrive;

constexpr int kBefore = 12;
constexpr int kAfter = 14;

/// The street's frame that the camera sees: `kBefore` frames from the start, then others, far ahead and backwards.
int seen_in(int frame) {
  constexpr int kFarOn = 59;
  return frame < kBefore ? frame : kFarOn - (frame - kBefore);
}

/// One street before the cut, another after it, which may have other vehicles.
class Cut : public ::testing::Test {
 protected:
  Cut(std::vector<Mover> before, std::vector<Mover> after) : before_(std::move(before)), after_(std::move(after)) {}
  Cut() : Cut({}, {}) {}

  [[nodiscard]] RenderedPair render(int frame) const {
    return (frame < kBefore ? before_ : after_).render(seen_in(frame));
  }
  void drive(PipelineRun& run) const {
    for (int frame = 0; frame < kBefore + kAfter; ++frame) {
      const std::string stem = test::stem_of(frame);
      run.step(render(frame).at(frame, stem));
    }
    run.drain();
  }

  StreetDrive before_;
  StreetDrive after_;
};

TEST_F(Cut, CostsTheCameraOneFrame) {
  PipelineRun run(small_config());
  drive(run);
  for (int frame = 0; frame < kBefore + kAfter; ++frame) {
    EXPECT_EQ(run.finalised[static_cast<std::size_t>(frame)].camera.status,
              frame == kBefore ? BodyStatus::kPropagated : BodyStatus::kTracked)
        << "frame " << frame;
  }
  EXPECT_EQ(run.counters.background_lost_frames, 1U);
}

TEST_F(Cut, IsNoMotion) {
  PipelineRun run(small_config());
  drive(run);
  const auto T_world_cam = [&](int frame) { return run.finalised[static_cast<std::size_t>(frame)].camera.T_world_cam; };
  EXPECT_LT((T_world_cam(kBefore - 1).inverse() * T_world_cam(kBefore)).translation.norm(), 1.0)
      << "it continues at its place";
  const int last = kBefore + kAfter - 1;
  const Se3 went = T_world_cam(kBefore).inverse() * T_world_cam(last);
  const Se3 truth = StreetDrive::T_world_cam(seen_in(kBefore)).inverse() * StreetDrive::T_world_cam(seen_in(last));
  EXPECT_LT((went.translation - truth.translation).norm(), 0.05) << went.translation.transpose();
}

TEST_F(Cut, ALongGapInTimeIsNoMotion) {
  constexpr int kDay = 864'000;  // Frames.
  PipelineRun run(small_config());
  for (int frame = 0; frame < kBefore + kAfter; ++frame) {
    run.step(before_.render(frame).at(frame < kBefore ? frame : frame + kDay));
  }
  run.drain();
  ASSERT_EQ(run.finalised.size(), static_cast<std::size_t>(kBefore + kAfter));
  EXPECT_EQ(run.finalised[kBefore].camera.status, BodyStatus::kLost);
  EXPECT_EQ(run.finalised.back().camera.status, BodyStatus::kTracked);
  EXPECT_LT((run.finalised[kBefore].camera.T_world_cam.translation -
             run.finalised[kBefore - 1].camera.T_world_cam.translation)
                .norm(),
            0.01)
      << "it continues at its place";
}

/// A vehicle drives ahead of the camera; after the cut another one does, at the same place in the image.
class CutWithVehicles : public Cut {
 protected:
  CutWithVehicles() : Cut({Mover{}}, {moving_back()}) {
    for (int frame = 0; frame < kBefore + kAfter; ++frame) {
      masks_.write(render(frame), frame);
    }
  }
  static Mover moving_back() {
    const double begin_s = seen_in(kBefore) * StreetDrive::kFrame_s;
    const Eigen::Vector3d ahead_m(-0.5, 0.4, 8.0);
    const Eigen::Vector3d velocity_mps(0.0, 0.0, 4.0);
    return {.start_m = StreetDrive::T_world_cam(seen_in(kBefore)) * ahead_m - begin_s * velocity_mps,
            .velocity_mps = velocity_mps};
  }
  MaskFolder masks_;
};

TEST_F(CutWithVehicles, EndsTracksAndBeginsNewOnes) {
  PipelineRun run(small_config(masks_));
  drive(run);
  EXPECT_EQ(run.counters.tracks_ended, 1U);
  const std::vector<std::uint32_t> ids = test::object_ids(run.finalised);
  ASSERT_EQ(ids.size(), 2U);
  for (const KeptEstimate& estimate : run.finalised) {
    const bool is_after = estimate.frame_index >= kBefore;
    EXPECT_EQ(estimate.object(ids[0]) != nullptr, !is_after) << "frame " << estimate.frame_index;
    EXPECT_TRUE(is_after || estimate.object(ids[1]) == nullptr) << "frame " << estimate.frame_index;
  }
  for (const std::vector<Track>& tracks : {run.tracks[kBefore], run.tracks.back()}) {
    ASSERT_EQ(tracks.size(), 1U);
    EXPECT_EQ(tracks[0].id, ids[1]) << "born in the first frame after the cut";
  }
  const ObjectResult* last = run.finalised.back().object(ids[1]);
  ASSERT_NE(last, nullptr);
  EXPECT_EQ(last->status, BodyStatus::kTracked);
}

/// Shows frames to the front end, and returns whether the last one follows a cut.
class CutDetectorTest : public ::testing::Test {
 protected:
  bool is_cut_after(const RenderedPair& pair, std::int64_t index) {
    for (int frame = 0; frame < 3; ++frame) {
      EXPECT_FALSE(show(street_.render(frame), frame)) << "frame " << frame;
    }
    return show(pair, index);
  }
  bool show(const RenderedPair& pair, std::int64_t index) {
    EXPECT_TRUE(front_end_.begin_frame(pair.at(index)));
    const bool is_cut = detector_.is_cut(front_end_.track({}).value(), features_, front_end_);
    features_ = front_end_.replenish({}).value().features.size();
    return is_cut;
  }

  StreetDrive street_;
  features::FeatureConfig config_ = small_config().features;
  Arena arena_{features::FeatureFrontEnd::required_bytes(config_, small_rig().width_px, small_rig().height_px)};
  features::FeatureFrontEnd front_end_ =
      features::FeatureFrontEnd::create(config_, small_rig().width_px, small_rig().height_px, arena_).value();
  CutDetector detector_{8.5};
  std::size_t features_ = 0;
};

TEST_F(CutDetectorTest, NextFrameOrSomethingElse) {
  EXPECT_FALSE(is_cut_after(street_.render(3), 3));
  EXPECT_TRUE(show(street_.render(70), 4));
  EXPECT_FALSE(show(street_.render(71), 5));
}

TEST_F(CutDetectorTest, WhereFramesAreMissingTheClockTells) {
  EXPECT_FALSE(is_cut_after(street_.render(70), 70));
}

TEST_F(CutDetectorTest, NoMotionIsPredictedOverALongGap) {
  EXPECT_TRUE(is_cut_after(street_.render(3), 90));
  EXPECT_FALSE(show(street_.render(4), 91));
}

TEST_F(CutDetectorTest, NothingToSeeIsNothingElse) {
  EXPECT_FALSE(is_cut_after(test::blank_pair(small_rig(), 0), 3));
  EXPECT_FALSE(show(street_.render(4), 4)) << "light again";
}

}  // namespace
}  // namespace kinetrace::pipeline

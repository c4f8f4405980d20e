// Phases of an object's life take the same time in seconds at 30 and at 10 frames a second.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline_run.hpp"

namespace kinetrace::pipeline {
namespace {

using Eigen::Vector3d;
using test::MaskFolder;
using test::PipelineRun;
using test::RenderedBox;
using test::RenderedPair;
using test::small_config;

constexpr std::uint8_t kObject = 1;
constexpr std::uint8_t kOther = 2;
constexpr Eigen::Index kAhead = 2;

/// Scene at a given time.
struct Shot {
  Se3 T_world_cam;
  std::vector<RenderedBox> boxes;
  bool detected = true;
};

struct Scene {
  std::string name;
  double length_s;
  Shot (*at)(double time_s);
};

RenderedBox box_at(const Vector3d& size_m, const Vector3d& centre_m, std::uint8_t label) {
  RenderedBox box;
  box.size_m = size_m;
  box.T_world_box.translation = centre_m;
  box.label = label;
  return box;
}

/// The object of all scenes, and a camera that creeps ahead.
Shot street_with_box(double time_s) {
  Shot shot;
  shot.T_world_cam.translation[kAhead] = 0.4 * time_s;
  shot.boxes = test::street_furniture();
  shot.boxes.push_back(box_at({1.6, 1.4, 1.5}, {-0.6, 0.5, 8.5}, kObject));
  return shot;
}

/// Another vehicle passes in front of it.
Shot occluded(double time_s) {
  Shot shot = street_with_box(time_s);
  shot.boxes.push_back(box_at({3.4, 2.0, 0.8}, {-6.5 + 3.0 * time_s, 0.4, 6.0}, kOther));
  return shot;
}

/// The camera looks to the right, and back.
Shot left_and_returned(double time_s) {
  Shot shot = street_with_box(time_s);
  const double part = std::clamp(std::min(time_s - 1.2, 4.4 - time_s), 0.0, 1.0);
  shot.T_world_cam.rotation = so3_exp({0.0, 0.9 * part, 0.0});
  return shot;
}

/// The object stands in view without detections for a while.
Shot standing_unseen(double time_s) {
  Shot shot = street_with_box(time_s);
  shot.detected = time_s < 1.95 || time_s > 4.45;
  return shot;
}

PipelineRun play(const Scene& scene, int rate_hz) {
  const test::RenderedWorld world;
  MaskFolder masks;
  std::vector<RenderedPair> pairs;
  const int frames = static_cast<int>(std::lround(scene.length_s * rate_hz));
  for (int frame = 0; frame < frames; ++frame) {
    const Shot shot = scene.at(static_cast<double>(frame) / rate_hz);
    RenderedPair& pair = pairs.emplace_back(world.render(shot.T_world_cam, shot.boxes));
    if (!shot.detected) {
      std::fill(pair.left_labels.begin(), pair.left_labels.end(), kBackgroundLabel);
      std::fill(pair.right_labels.begin(), pair.right_labels.end(), kBackgroundLabel);
    }
    masks.write(pair, frame);
  }
  PipelineRun run(small_config(masks));
  for (int frame = 0; frame < frames; ++frame) {
    const std::string stem = test::stem_of(frame);
    RectifiedPair pair = pairs[static_cast<std::size_t>(frame)].at(frame, stem);
    pair.timestamp_ns = std::llround(1e9 * frame / rate_hz);
    run.step(pair);
  }
  run.drain();
  return run;
}

/// Phases of the object of track 1, in seconds.
struct Life {
  double tentative_s = 0.0;
  double detected_s = 0.0;
  double predicted_s = 0.0;  ///< Without a detection, with a predicted mask.
  double waiting_s = 0.0;    ///< Without a mask.
  double lost_s = 0.0;       ///< No longer reported with a known position.
  std::size_t ids = 0;       ///< Of all tracks that were reported.
};

Life life_of(const PipelineRun& run, int rate_hz) {
  constexpr std::uint32_t kId = 1;
  const double frame_s = 1.0 / rate_hz;
  Life life;
  for (std::size_t frame = 0; frame < run.tracks.size(); ++frame) {
    for (const Track& track : run.tracks[frame]) {
      if (track.id != kId) {
        continue;
      }
      life.tentative_s += track.state == TrackState::kTentative ? frame_s : 0.0;
      life.detected_s += track.missed_frames == 0 ? frame_s : 0.0;
      life.predicted_s += track.missed_frames > 0 && track.area_px > 0 ? frame_s : 0.0;
      life.waiting_s += track.missed_frames > 0 && track.area_px == 0 ? frame_s : 0.0;
    }
    const ObjectResult* const row = run.newest[frame].object(kId);
    life.lost_s += row == nullptr || row->status == BodyStatus::kLost ? frame_s : 0.0;
  }
  life.ids = test::object_ids(run.finalised).size();
  return life;
}

class PipelineRate : public ::testing::TestWithParam<Scene> {};

TEST_P(PipelineRate, AThirdOfTheIntervalChangesNothingInAnObjectsLife) {
  const Life slow = life_of(play(GetParam(), 10), 10);
  const Life fast = life_of(play(GetParam(), 30), 30);
  // A frame at 10 Hz on either side of a change.
  constexpr double kTolerance_s = 0.21;
  EXPECT_GE(slow.predicted_s + slow.waiting_s, 0.7) << "the scene hides the object";
  EXPECT_EQ(fast.ids, slow.ids);
  EXPECT_LE(fast.tentative_s, slow.tentative_s) << "detections confirm a track, and they come sooner";
  EXPECT_NEAR(fast.detected_s, slow.detected_s, kTolerance_s);
  EXPECT_NEAR(fast.predicted_s, slow.predicted_s, kTolerance_s);
  EXPECT_NEAR(fast.waiting_s, slow.waiting_s, kTolerance_s);
  EXPECT_NEAR(fast.lost_s, slow.lost_s, kTolerance_s);
}

INSTANTIATE_TEST_SUITE_P(Scenes, PipelineRate,
                         ::testing::Values(Scene{"Occluded", 4.4, occluded},
                                           Scene{"LeftAndReturned", 5.2, left_and_returned},
                                           Scene{"StandingUnseen", 5.4, standing_unseen}),
                         [](const ::testing::TestParamInfo<Scene>& scene) { return scene.param.name; });

}  // namespace
}  // namespace kinetrace::pipeline

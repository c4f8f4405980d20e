// Invariants of the tracks of every frame, for any detections: alive, in ascending id, each once.
#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "mask_scene.hpp"

namespace kinetrace::tracking {
namespace {

constexpr std::size_t kShapes = 6;
constexpr int kFrames = 80;

/// Shapes that drift, are missed now and then, vanish for a while and come back.
class RandomScene {
 public:
  explicit RandomScene(unsigned seed) : random_(seed), scene_(config(), 8) {
    for (Shape& shape : shapes_) {
      shape = {.x = uniform(0.0, kWidth),
               .y = uniform(40.0, kHeight - 40.0),
               .half_width = uniform(10.0, 50.0),
               .half_height = uniform(10.0, 40.0),
               .disparity_px = uniform(4.0, 30.0)};
    }
    scene_.detected.assign(kShapes, true);
  }

  void step() {
    for (std::size_t k = 0; k < kShapes; ++k) {
      shapes_[k].x = chance(0.03) ? uniform(-60.0, kWidth + 60.0) : shapes_[k].x + uniform(-8.0, 8.0);
      scene_.detected[k] = chance(scene_.detected[k] ? 0.85 : 0.3);
    }
    scene_.available = chance(0.95);
    scene_.with_right = chance(0.5);
    scene_.object_predictions.assign(kShapes, {});
    for (ObjectPrediction& prediction : scene_.object_predictions) {
      prediction = {chance(0.7), {uniform(0.0, kWidth), uniform(0.0, kHeight)}, uniform(3.0, 30.0)};
    }
    scene_.tracker().limit(chance(0.1) ? 3 : 8);
    before_.assign(tracker().tracks().begin(), tracker().tracks().end());
    scene_.step(shapes_);
  }

  /// As a pipeline re-identifies objects: lost tracks continue as tracks born since.
  int join_some() {
    int joined = 0;
    for (std::size_t i = 0; i < tracker().tracks().size(); ++i) {
      const Track redetected = tracker().tracks()[i];
      for (const Track& earlier : tracker().tracks().first(i)) {
        if (earlier.missed_frames > redetected.age_frames && chance(0.4)) {
          tracker().merge_tracks(earlier.slot, redetected.slot);
          ++joined;
          break;
        }
      }
      if (chance(0.02)) {
        tracker().terminate(redetected.slot);
      }
    }
    return joined;
  }

  /// Splits redetected tracks that show another object.
  int split_some() {
    int split = 0;
    for (const Track& before : before_) {
      const auto now = std::find_if(tracker().tracks().begin(), tracker().tracks().end(),
                                    [&](const Track& track) { return track.id == before.id; });
      const bool is_back = now != tracker().tracks().end() && now->missed_frames == 0 && before.missed_frames > 0;
      if (is_back && chance(0.5)) {
        split += tracker().split_track(now->slot, before) ? 1 : 0;
      }
    }
    return split;
  }

  [[nodiscard]] StereoTracker& tracker() { return scene_.tracker(); }
  [[nodiscard]] const TrackFrame& frame() const { return scene_.frame(); }

 private:
  static TrackerConfig config() {
    TrackerConfig config;
    config.max_objects = 8;
    config.max_unseen_s = 2.0;
    return config;
  }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  bool chance(double part) { return uniform(0.0, 1.0) < part; }

  std::mt19937 random_;
  TrackerScene scene_;
  std::array<Shape, kShapes> shapes_;
  std::vector<Track> before_;
};

void expect_sound(const StereoTracker& tracker, const TrackFrame& frame) {
  std::array<bool, 256> reported{};
  reported[kBackgroundLabel] = reported[kIgnoreLabel] = true;
  std::uint32_t last_id = 0;
  for (const Track& track : tracker.tracks()) {
    EXPECT_GT(track.id, last_id);
    last_id = track.id;
    EXPECT_FALSE(reported[track.label()]) << "a slot twice";
    reported[track.label()] = true;
    EXPECT_EQ(track.missed_frames > 0, track.missed_ns > 0);
    EXPECT_TRUE(std::none_of(frame.ended.begin(), frame.ended.end(), [&](const Track& t) { return t.id == track.id; }));
  }
  for (const LabelView& labels : {frame.left_labels, frame.right_labels}) {
    for (int y = 0; y < labels.height; ++y) {
      ASSERT_TRUE(std::all_of(labels.row(y), labels.row(y) + labels.width, [&](std::uint8_t l) { return reported[l]; }))
          << "a label of no track, row " << y;
    }
  }
}

class TrackList : public ::testing::TestWithParam<unsigned> {};

TEST_P(TrackList, IsAliveSortedAndUniqueInEveryFrame) {
  RandomScene scene(GetParam());
  int joined = 0;
  int split = 0;
  for (int i = 0; i < kFrames && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    scene.step();
    expect_sound(scene.tracker(), scene.frame());
    split += scene.split_some();
    expect_sound(scene.tracker(), scene.frame());
    joined += scene.join_some();
    expect_sound(scene.tracker(), scene.frame());
  }
  EXPECT_GE(joined, 2);
  EXPECT_GE(split, 1);
}

INSTANTIATE_TEST_SUITE_P(Seeds, TrackList, ::testing::Range(1U, 4U));

}  // namespace
}  // namespace kinetrace::tracking

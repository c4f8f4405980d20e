// Re-identification of lost objects among new tracks: too far away for stereo, without images.
#include "object_set.hpp"

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "seen_track.hpp"
#include "street_drive.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr PixelBox kThere{60, 40, 68, 46};

Track track_of(std::uint8_t slot, int missed_frames) {
  return seen_track(slot + 1U, slot, kThere, missed_frames);
}

class ObjectSetTest : public ::testing::Test {
 protected:
  ObjectSetTest()
      : config_(test::small_config()),
        geometry_(test::small_rig()),
        arena_(ObjectSet::required_bytes(config_)),
        objects_(ObjectSet::create(config_, geometry_, arena_).value()) {
    camera_.valid = true;
    for (int frame = 0; frame < 3; ++frame) {
      observe(track_of(0, 0));
    }
    for (int missed = 1; missed <= 4; ++missed) {
      observe(track_of(0, missed));
    }
  }

  void observe(const Track& track) {
    const std::vector<Track> tracks{track};
    objects_.take_tracks({.left_labels = {}, .right_labels = {}, .tracks = tracks, .ended = {}});
    frame_.timestamp_ns += kFrame_ns;
    EXPECT_TRUE(objects_.observe(track, frame_, {}, camera_));
    objects_.conclude({}, camera_, {});
  }
  /// Number of lost objects re-identified in a frame with these tracks.
  std::size_t reidentified(const std::vector<Track>& tracks) {
    objects_.take_tracks({.left_labels = {}, .right_labels = {}, .tracks = tracks, .ended = {}});
    return objects_.reidentify(tracks, frame_, {}, camera_).size();
  }

  PipelineConfig config_;
  StereoGeometry geometry_;
  Arena arena_;
  ObjectSet objects_;
  CameraState camera_;
  FeatureFrame frame_{};
};

TEST_F(ObjectSetTest, ALostObjectContinuesAsTheNewTrackInItsDirection) {
  EXPECT_EQ(reidentified({track_of(0, 5), track_of(1, 0)}), 1U);
  EXPECT_EQ(objects_.slots()[1].track().id, 1U);
}

TEST_F(ObjectSetTest, WhatIsDetectedInThisFrameIsNotLost) {
  EXPECT_EQ(reidentified({track_of(0, 0), track_of(1, 0)}), 0U) << "it has come in two pieces";
}

TEST_F(ObjectSetTest, WhatWasSplitFromATrackIsNotMergedWithItAtOnce) {
  Track waiting = track_of(1, 5);
  waiting.id = 1;
  Track seen = track_of(0, 0);
  seen.id = 2;
  objects_.split(seen, waiting);
  EXPECT_EQ(reidentified({waiting, seen}), 0U);
  EXPECT_EQ(reidentified({waiting, track_of(2, 0)}), 1U) << "another one may be it";
}

}  // namespace
}  // namespace kinetrace::pipeline

// Detections and tracks beyond the capacity.
#include <set>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mask_scene.hpp"

namespace kinetrace::tracking {
namespace {

constexpr Shape kCar{.x = 100.0, .y = 100.0};

std::vector<Shape> row_of_shapes(int count) {
  std::vector<Shape> shapes;
  shapes.reserve(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    shapes.push_back({.x = 40.0 + 70.0 * k, .y = 100.0, .half_width = 12.0 + k, .half_height = 10.0});
  }
  return shapes;
}

TEST(StereoTracker, HoldsAsManyTracksAsConfigured) {
  TrackerScene scene;
  const TrackFrame& frame = scene.step(row_of_shapes(8));
  EXPECT_EQ(frame.tracks.size(), 8U);
  EXPECT_EQ(scene.tracker().counters().detections_dropped, 0U);
}

TEST(StereoTracker, DropsTheSmallestDetectionBeyondItsCapacity) {
  TrackerConfig config;
  config.max_objects = 8;
  TrackerScene scene(config);
  const std::vector<Shape> shapes = row_of_shapes(9);
  const TrackFrame& frame = scene.step(shapes);
  EXPECT_EQ(frame.tracks.size(), 8U);
  EXPECT_EQ(scene.track_of(0), nullptr);
  EXPECT_EQ(scene.tracker().counters().detections_dropped, 1U);
  EXPECT_EQ(area_of(frame.left_labels, kIgnoreLabel), scene.detections().left[0].area_px);
  for (std::size_t i = 1; i < frame.tracks.size(); ++i) {
    EXPECT_LT(frame.tracks[i - 1].id, frame.tracks[i].id);
  }
}

TEST(StereoTracker, MakesRoomByEndingALongPropagatedTrack) {
  TrackerConfig config;
  config.max_objects = 1;
  TrackerScene scene(config);
  const Shape other = shifted(kCar, 300.0);
  for (int i = 0; i < 3; ++i) {
    scene.step(std::array{kCar});
  }
  scene.detected = {false, true};
  for (int missed = 1; missed <= 5; ++missed) {
    EXPECT_EQ(scene.step(std::array{kCar, other}).tracks[0].id, 1U);
  }
  EXPECT_EQ(scene.step(std::array{kCar, other}).ended.size(), 1U) << "propagated for more than half of its time";
  const TrackFrame& frame = scene.step(std::array{kCar, other});
  ASSERT_EQ(frame.tracks.size(), 1U);
  EXPECT_EQ(frame.tracks[0].id, 2U);
}

TEST(StereoTracker, GivesTheSlotOfTheSmallestTrackToADetectionTwiceItsSize) {
  TrackerConfig config;
  config.max_objects = 2;
  TrackerScene scene(config);
  const Shape small{.x = 60.0, .y = 60.0, .half_width = 10.0, .half_height = 10.0};
  const Shape large{.x = 400.0, .y = 120.0, .half_width = 60.0, .half_height = 40.0};
  for (int i = 0; i < 3; ++i) {
    scene.step(std::array{small, kCar});
  }
  const TrackFrame& full = scene.step(std::array{small, kCar, large});
  ASSERT_EQ(full.ended.size(), 1U);
  EXPECT_EQ(full.ended[0].id, 2U) << "births go by size";
  EXPECT_EQ(full.tracks.size(), 1U);
  EXPECT_EQ(area_of(full.left_labels, full.ended[0].label()), 0) << "nothing is left of the track that has ended";
  const TrackFrame& after = scene.step(std::array{small, kCar, large});
  EXPECT_TRUE(after.ended.empty());
  EXPECT_NE(scene.track_of(2), nullptr);
  EXPECT_EQ(scene.track_of(0), nullptr);
}

TEST(StereoTracker, KeepsTheSmallestTrackAgainstADetectionOfItsSize) {
  TrackerConfig config;
  config.max_objects = 1;
  TrackerScene scene(config);
  for (int i = 0; i < 6; ++i) {
    const TrackFrame& frame = scene.step(std::array{kCar, shifted(kCar, 300.0)});
    EXPECT_EQ(frame.tracks[0].id, 1U);
    EXPECT_TRUE(frame.ended.empty());
  }
}

TEST(StereoTracker, DropsDetectionsBelowTheSmallestArea) {
  TrackerScene scene;
  const Shape dot{.x = 50.0, .y = 50.0, .half_width = 3.0, .half_height = 3.0};  // 49 px
  EXPECT_TRUE(scene.step(std::array{dot}).tracks.empty());
  EXPECT_EQ(scene.tracker().counters().detections_dropped, 1U);
}

TEST(StereoTracker, ALimitEndsUnseenAndSmallTracksFirst) {
  TrackerScene scene;
  const Shape large{.x = 60.0, .y = 60.0, .half_width = 40.0, .half_height = 30.0};
  const Shape medium{.x = 240.0, .y = 60.0};
  const Shape small{.x = 60.0, .y = 180.0, .half_width = 12.0, .half_height = 12.0};
  const Shape missed{.x = 240.0, .y = 180.0, .half_width = 45.0, .half_height = 35.0};
  const std::array all{large, medium, small, missed};
  for (int i = 0; i < 4; ++i) {
    scene.step(all);
  }
  scene.detected = {true, true, true, false};
  ASSERT_EQ(scene.step(all).tracks.size(), 4U);
  const std::uint32_t large_id = scene.track_of(0)->id;
  const std::uint32_t medium_id = scene.track_of(1)->id;
  const std::uint32_t small_id = scene.track_of(2)->id;

  const auto left_after = [&](int most) {
    scene.tracker().limit(most);
    std::set<std::uint32_t> ids;
    for (const Track& track : scene.step(all).tracks) {
      ids.insert(track.id);
    }
    return ids;
  };
  EXPECT_EQ(left_after(3), (std::set{large_id, medium_id, small_id}));
  EXPECT_EQ(left_after(2), (std::set{large_id, medium_id}));
  EXPECT_EQ(left_after(2), (std::set{large_id, medium_id})) << "the small one, still detected, is not born";
  EXPECT_EQ(scene.frame().ended.size(), 0U);
  scene.detected = {};
  EXPECT_EQ(left_after(4).size(), 4U) << "what is seen is born again";
}

}  // namespace
}  // namespace kinetrace::tracking

// Birth, confirmation, propagation, end; ids and slots.
#include <array>
#include <optional>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mask_scene.hpp"

namespace kinetrace::tracking {
namespace {

using ::testing::HasSubstr;

constexpr Shape kCar{.x = 100.0, .y = 100.0};

/// In the default settings, at 10 Hz.
constexpr int kMissedFrames = 10;
constexpr int kUnseenFrames = 75;

TEST(StereoTracker, IsEmptyWithoutDetections) {
  TrackerScene scene;
  const TrackFrame& frame = scene.step({});
  EXPECT_TRUE(frame.tracks.empty());
  EXPECT_TRUE(frame.ended.empty());
  EXPECT_EQ(area_of(frame.left_labels, kBackgroundLabel), kWidth * kHeight);
  EXPECT_EQ(area_of(frame.right_labels, kBackgroundLabel), kWidth * kHeight);
}

TEST(StereoTracker, AcceptsDetectionsWithoutALabelImage) {
  TrackerScene scene;
  DetectionFrame nothing;
  nothing.available = true;
  EXPECT_TRUE(scene.tracker().process(scene.next_timestamp_ns(), nothing, {}).has_value());
}

TEST(StereoTracker, ConfirmsInTheThirdMatchedFrame) {
  TrackerScene scene;
  for (int i = 0; i < 5; ++i) {
    const TrackFrame& frame = scene.step(std::array{shifted(kCar, 3.0 * i)});
    ASSERT_EQ(frame.tracks.size(), 1U);
    EXPECT_EQ(frame.tracks[0].id, 1U);
    EXPECT_EQ(frame.tracks[0].age_frames, i);
    EXPECT_EQ(frame.tracks[0].state, i < 2 ? TrackState::kTentative : TrackState::kConfirmed);
    EXPECT_EQ(frame.tracks[0].class_id, kVehicleClass);
  }
  EXPECT_EQ(scene.tracker().counters().born, 1U);
  EXPECT_EQ(scene.tracker().counters().confirmed, 1U);
}

TEST(StereoTracker, PropagatesForTenFramesAndEndsInTheNext) {
  TrackerScene scene;
  for (int i = 0; i < 4; ++i) {
    scene.step(std::array{shifted(kCar, 5.0 * i)});
  }
  scene.detected = {false};
  for (int missed = 1; missed <= 10; ++missed) {
    const TrackFrame& frame = scene.step(std::array{shifted(kCar, 5.0 * (3 + missed))});
    ASSERT_EQ(frame.tracks.size(), 1U) << missed;
    EXPECT_EQ(frame.tracks[0].state, TrackState::kPropagated);
    EXPECT_EQ(frame.tracks[0].missed_frames, missed);
    EXPECT_GE(scene.left_iou(frame.tracks[0], 0), 0.9) << missed;
  }
  const TrackFrame& last = scene.step(std::array{shifted(kCar, 75.0)});
  EXPECT_TRUE(last.tracks.empty());
  ASSERT_EQ(last.ended.size(), 1U);
  EXPECT_EQ(last.ended[0].id, 1U);
  EXPECT_EQ(area_of(last.left_labels, kBackgroundLabel), kWidth * kHeight);
  EXPECT_TRUE(scene.step(std::array{kCar}).ended.empty());
  EXPECT_EQ(scene.tracker().counters().ended, 1U);
}

TEST(StereoTracker, EndsATentativeTrackAfterTwoMisses) {
  TrackerScene scene;
  scene.step(std::array{kCar});
  scene.detected = {false};
  EXPECT_EQ(scene.step(std::array{kCar}).tracks.size(), 1U);
  EXPECT_EQ(scene.step(std::array{kCar}).ended.size(), 1U);
}

TEST(StereoTracker, PropagatesATentativeTrackThroughFramesWithoutDetections) {
  TrackerScene scene;
  scene.step(std::array{kCar});
  scene.available = false;
  for (int i = 0; i < 4; ++i) {
    const TrackFrame& frame = scene.step(std::array{kCar});
    ASSERT_EQ(frame.tracks.size(), 1U);
    EXPECT_EQ(frame.tracks[0].state, TrackState::kTentative);
    EXPECT_GT(scene.left_iou(frame.tracks[0], 0), 0.99);
  }
  scene.available = true;
  scene.step(std::array{kCar});
  EXPECT_EQ(scene.step(std::array{kCar}).tracks[0].state, TrackState::kConfirmed);
}

TEST(StereoTracker, PropagatesATentativeTrackWhereTheImageWasNotSearched) {
  const auto ended_of = [](const PixelBox& searched_px) {
    TrackerScene scene;
    scene.step(std::array{kCar});
    scene.detected = {false};
    scene.searched_px = searched_px;
    std::size_t ended = 0;
    for (int i = 0; i < 4; ++i) {
      ended += scene.step(std::array{kCar}).ended.size();
    }
    return ended;
  };
  EXPECT_EQ(ended_of({0, 0, kWidth, kHeight}), 1U);
  EXPECT_EQ(ended_of({static_cast<int>(kCar.x) + 2, 0, kWidth, kHeight}), 0U) << "a part of it was not looked at";
}

TEST(StereoTracker, PropagatesATentativeTrackOfAKnownClassWhereOnlyWhatMovesWasLookedFor) {
  const auto ended_of = [](std::uint16_t class_id) {
    Shape shape = kCar;
    shape.class_id = class_id;
    TrackerScene scene;
    scene.step(std::array{shape});
    scene.detected = {false};
    scene.moving_only = true;
    std::size_t ended = 0;
    for (int i = 0; i < 4; ++i) {
      ended += scene.step(std::array{shape}).ended.size();
    }
    return ended;
  };
  EXPECT_EQ(ended_of(kVehicleClass), 0U) << "it may stand";
  EXPECT_EQ(ended_of(kUnknownClass), 1U) << "it was found by its motion, and has none any more";
}

TEST(StereoTracker, EndsATrackOfWhichNoDetectionIsEverAvailable) {
  TrackerConfig config;
  config.max_missed_s = 0.3;
  TrackerScene scene(config);
  scene.step(std::array{kCar});
  scene.available = false;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(scene.step(std::array{kCar}).tracks.size(), 1U);
  }
  EXPECT_EQ(scene.step(std::array{kCar}).ended.size(), 1U);
}

TEST(StereoTracker, EndsATrackThatLeavesTheImage) {
  TrackerScene scene;
  double x = 560.0;
  for (int i = 0; i < 4; ++i, x += 12.0) {
    scene.step(std::array{shifted(kCar, x - kCar.x)});
  }
  scene.detected = {false};
  std::size_t ended = 0;
  for (int i = 0; i < 8; ++i, x += 12.0) {
    ended += scene.step(std::array{shifted(kCar, x - kCar.x)}).ended.size();
  }
  EXPECT_EQ(ended, 1U);
}

TEST(StereoTracker, NeverReusesAnIdAndASlotOnlyInALaterFrame) {
  TrackerConfig config;
  config.max_objects = 1;
  config.max_missed_s = 0.0;
  config.max_tentative_missed_s = 0.0;
  TrackerScene scene(config, 0);
  std::set<std::uint32_t> ids;
  for (int i = 0; i < 20; ++i) {
    // In odd frames the object jumps: its track ends while a new detection waits for the slot.
    const bool jumps = i % 2 == 1;
    const TrackFrame& frame = scene.step(std::array{shifted(kCar, (i + 1) / 2 % 2 == 0 ? 0.0 : 300.0)});
    EXPECT_EQ(frame.ended.size(), jumps ? 1U : 0U);
    ASSERT_EQ(frame.tracks.size(), jumps ? 0U : 1U);
    if (!jumps) {
      EXPECT_EQ(frame.tracks[0].slot, 0);
      EXPECT_TRUE(ids.insert(frame.tracks[0].id).second);
    }
  }
  EXPECT_EQ(ids.size(), 10U);
}

/// Prediction of a shape's centre, with the depth of its disparity.
ObjectPrediction prediction_of(const Shape& shape) {
  return {true, {shape.x, shape.y}, 100.0 / shape.disparity_px};
}

/// Three frames in view, then `away` frames outside the image on the right, then back in view.
void look_away(TrackerScene& scene, int away, bool with_prediction) {
  const auto step = [&](const Shape& shape, bool visible) {
    scene.object_predictions.assign(1, with_prediction ? prediction_of(shape) : ObjectPrediction{});
    scene.detected = {visible};
    scene.step(std::array{shape});
  };
  for (int i = 0; i < 4; ++i) {
    step(shifted(kCar, 400.0), true);
  }
  for (int i = 0; i < away; ++i) {
    step(shifted(kCar, 900.0), false);
  }
  step(shifted(kCar, 380.0), true);
}

TEST(StereoTracker, KeepsTheIdOfWhatComesBackIntoTheImage) {
  TrackerScene scene;
  look_away(scene, 40, true);
  ASSERT_EQ(scene.frame().tracks.size(), 1U);
  EXPECT_EQ(scene.frame().tracks[0].id, 1U);
  EXPECT_EQ(scene.frame().tracks[0].missed_frames, 0);
}

TEST(StereoTracker, ForgetsWhatStaysOutsideTheImageTooLong) {
  TrackerScene scene;
  look_away(scene, kUnseenFrames + kMissedFrames + 2, true);
  ASSERT_EQ(scene.frame().tracks.size(), 1U);
  EXPECT_EQ(scene.frame().tracks[0].id, 2U);
}

TEST(StereoTracker, EndsWhatLeavesTheImageWithoutAPrediction) {
  TrackerScene scene;
  look_away(scene, 12, false);
  ASSERT_EQ(scene.frame().tracks.size(), 1U);
  EXPECT_EQ(scene.frame().tracks[0].id, 2U);
}

/// A confirmed track of a car with a static prediction and without detections for `missed` frames.
void miss_in_view(TrackerScene& scene, int missed, bool with_prediction = true) {
  for (int i = 0; i < 4; ++i) {
    scene.step(std::array{kCar});
  }
  scene.object_predictions.assign(1, with_prediction ? prediction_of(kCar) : ObjectPrediction{});
  scene.detected = {false};
  for (int i = 0; i < missed; ++i) {
    scene.step(std::array{kCar});
  }
}

TEST(StereoTracker, WaitsWhereItShouldBeInViewButClaimsNoPixels) {
  TrackerScene scene;
  miss_in_view(scene, kMissedFrames);
  ASSERT_EQ(scene.frame().tracks.size(), 1U);
  EXPECT_GT(scene.frame().tracks[0].area_px, 0) << "still shows its prediction";
  for (int missed = kMissedFrames + 1; missed <= kMissedFrames + kUnseenFrames; ++missed) {
    const TrackFrame& frame = scene.step(std::array{kCar});
    ASSERT_EQ(frame.tracks.size(), 1U) << missed;
    EXPECT_EQ(frame.tracks[0].id, 1U);
    EXPECT_EQ(frame.tracks[0].missed_frames, missed);
    EXPECT_EQ(frame.tracks[0].area_px, 0) << missed;
    ASSERT_EQ(area_of(frame.left_labels, kBackgroundLabel), kWidth * kHeight) << missed;
  }
  const TrackFrame& last = scene.step(std::array{kCar});
  EXPECT_TRUE(last.tracks.empty());
  ASSERT_EQ(last.ended.size(), 1U);
  EXPECT_EQ(last.ended[0].id, 1U);
}

/// Seconds from the last detection of a car that should be in view until its mask is no longer shown, and until it
/// ends.
std::pair<double, double> waits_s(std::int64_t interval_ns) {
  TrackerScene scene;
  scene.interval_ns = interval_ns;
  miss_in_view(scene, 0);
  scene.detected = {false};
  double shown_s = 0.0;
  double alive_s = 0.0;
  while (scene.step(std::array{kCar}).ended.empty() && alive_s < 20.0) {
    alive_s += 1e-9 * static_cast<double>(interval_ns);
    shown_s = scene.frame().tracks[0].area_px > 0 ? alive_s : shown_s;
  }
  return {shown_s, alive_s};
}

TEST(StereoTracker, WaitsAsManySecondsAtEveryRate) {
  for (const int rate_hz : {5, 10, 30}) {
    const auto [shown_s, alive_s] = waits_s(1'000'000'000 / rate_hz);
    EXPECT_NEAR(shown_s, 1.0, 1e-3) << rate_hz << " Hz";
    EXPECT_NEAR(alive_s, 8.5, 0.5 / rate_hz + 1e-3) << rate_hz << " Hz";
  }
}

TEST(StereoTracker, EndsWhatIsMissedInViewWithoutAPrediction) {
  TrackerScene scene;
  miss_in_view(scene, kMissedFrames, false);
  ASSERT_EQ(scene.frame().tracks.size(), 1U);
  EXPECT_EQ(scene.step(std::array{kCar}).ended.size(), 1U);
}

TEST(StereoTracker, ClaimsADetectionWhereItIsPredictedAndNoneOnceItWaits) {
  for (const int missed : {kMissedFrames, kMissedFrames + 1}) {
    TrackerScene scene({}, 0);  // Without features, which would associate it.
    miss_in_view(scene, missed);
    scene.detected = {true};
    const TrackFrame& frame = scene.step(std::array{kCar});
    const Track* shown = scene.track_of(0);
    ASSERT_NE(shown, nullptr) << missed;
    const bool waits = missed > kMissedFrames;
    EXPECT_EQ(frame.tracks.size(), waits ? 2U : 1U) << missed;
    EXPECT_EQ(shown->id, waits ? 2U : 1U) << missed;
    EXPECT_GT(scene.left_iou(*shown, 0), 0.99) << missed;
  }
}

TEST(StereoTracker, HidesNothingWhereItWaitsInView) {
  TrackerScene scene;
  miss_in_view(scene, kMissedFrames + 1);
  scene.detected = {true};
  scene.object_predictions.assign(2, prediction_of(kCar));
  for (int i = 0; i < 5; ++i) {
    const TrackFrame& frame = scene.step(std::array{kCar});
    ASSERT_EQ(frame.tracks.size(), 2U) << i;
    EXPECT_EQ(frame.tracks[1].missed_frames, 0) << i;
    EXPECT_GT(frame.tracks[1].visible_part, 0.9F) << i;
    EXPECT_GT(scene.left_iou(frame.tracks[1], 0), 0.99) << i;
  }
}

TEST(StereoTracker, ContinuesAfterWaitingInViewWhenJoined) {
  TrackerScene scene;
  miss_in_view(scene, kMissedFrames + 5);
  scene.detected = {true};
  scene.step(std::array{kCar});
  ASSERT_EQ(scene.frame().tracks.size(), 2U);
  scene.tracker().merge_tracks(scene.frame().tracks[0].slot, scene.frame().tracks[1].slot);
  scene.object_predictions.clear();
  const TrackFrame& frame = scene.step(std::array{kCar});
  ASSERT_EQ(frame.tracks.size(), 1U);
  EXPECT_EQ(frame.tracks[0].id, 1U);
  EXPECT_EQ(frame.tracks[0].state, TrackState::kConfirmed);
  EXPECT_EQ(frame.tracks[0].missed_frames, 0);
  EXPECT_TRUE(frame.ended.empty());
}

TEST(StereoTracker, EndsATerminatedTrackWithTheNextFrame) {
  TrackerScene scene;
  for (int i = 0; i < 3; ++i) {
    scene.step(std::array{kCar});
  }
  scene.tracker().terminate(scene.frame().tracks[0].slot);
  scene.tracker().terminate(200);
  const TrackFrame& frame = scene.step(std::array{kCar});
  ASSERT_EQ(frame.ended.size(), 1U);
  EXPECT_EQ(frame.ended[0].id, 1U);
  ASSERT_EQ(frame.tracks.size(), 1U);
  EXPECT_EQ(frame.tracks[0].id, 2U);
}

/// Seen, missed, and detected again.
Track returns_after_a_break(TrackerScene& scene) {
  for (int i = 0; i < 3; ++i) {
    scene.step(std::array{kCar});
  }
  scene.detected = {false};
  scene.step(std::array{kCar});
  scene.step(std::array{kCar});
  const Track before = scene.frame().tracks[0];
  scene.detected = {true};
  scene.step(std::array{kCar});
  EXPECT_EQ(scene.frame().tracks[0].missed_frames, 0);
  return before;
}

TEST(StereoTracker, WaitsWhereItsDetectionShowsSomethingElse) {
  TrackerScene scene;
  const Track before = returns_after_a_break(scene);
  const std::optional<std::uint8_t> waiting = scene.tracker().split_track(before.slot, before);
  ASSERT_TRUE(waiting.has_value());
  ASSERT_EQ(scene.tracker().tracks().size(), 2U);
  const Track& old = scene.tracker().tracks()[0];
  const Track& born = scene.tracker().tracks()[1];
  EXPECT_EQ(old.id, 1U);
  EXPECT_EQ(old.slot, *waiting);
  EXPECT_EQ(old.state, TrackState::kPropagated);
  EXPECT_EQ(old.missed_frames, before.missed_frames + 1);
  EXPECT_EQ(old.area_px, 0);
  EXPECT_EQ(born.id, 2U);
  EXPECT_EQ(born.slot, before.slot);
  EXPECT_EQ(born.state, TrackState::kTentative);
  EXPECT_GT(scene.left_iou(born, 0), 0.99) << "what is detected is the new one's";
  EXPECT_EQ(scene.tracker().counters().born, 2U);
  scene.object_predictions.assign(2, prediction_of(kCar));
  const TrackFrame& frame = scene.step(std::array{kCar});
  ASSERT_EQ(frame.tracks.size(), 2U);
  EXPECT_EQ(frame.tracks[0].missed_frames, before.missed_frames + 2) << "and stays so, wherever it is expected";
  EXPECT_EQ(frame.tracks[1].missed_frames, 0);
}

TEST(StereoTracker, IsWholeAgainWhenSplitByMistakeAndJoined) {
  TrackerScene scene;
  const Track before = returns_after_a_break(scene);
  const std::uint8_t waiting = scene.tracker().split_track(before.slot, before).value();
  scene.tracker().merge_tracks(waiting, before.slot);
  ASSERT_EQ(scene.tracker().tracks().size(), 1U);
  EXPECT_EQ(scene.tracker().tracks()[0].id, 1U);
  EXPECT_EQ(scene.tracker().tracks()[0].state, TrackState::kConfirmed);
  EXPECT_EQ(scene.step(std::array{kCar}).tracks[0].id, 1U);
}

TEST(StereoTracker, IsNotSplitWhereNoSlotIsFree) {
  TrackerConfig config;
  config.max_objects = 1;
  TrackerScene scene(config);
  const Track before = returns_after_a_break(scene);
  EXPECT_FALSE(scene.tracker().split_track(before.slot, before));
  ASSERT_EQ(scene.tracker().tracks().size(), 1U);
  EXPECT_EQ(scene.tracker().tracks()[0].id, 1U);
}

TEST(StereoTracker, ContinuesUnderTheEarlierIdAfterJoining) {
  TrackerScene scene;
  const Shape other = shifted(kCar, 300.0);
  for (int i = 0; i < 3; ++i) {
    scene.step(std::array{kCar});
  }
  scene.detected = {false, true};
  scene.step(std::array{kCar, other});
  ASSERT_EQ(scene.frame().tracks.size(), 2U);
  const Track earlier = scene.frame().tracks[0];
  ASSERT_GT(area_of(scene.frame().left_labels, earlier.label()), 0);
  scene.tracker().merge_tracks(earlier.slot, scene.frame().tracks[1].slot);
  ASSERT_EQ(scene.tracker().tracks().size(), 1U) << "in this frame, too";
  EXPECT_EQ(scene.tracker().tracks()[0].id, 1U);
  EXPECT_EQ(scene.tracker().tracks()[0].missed_frames, 0);
  EXPECT_EQ(area_of(scene.frame().left_labels, earlier.label()), 0) << "nothing is left of where it was expected";
  const TrackFrame& frame = scene.step(std::array{kCar, other});
  ASSERT_EQ(frame.tracks.size(), 1U);
  EXPECT_EQ(frame.tracks[0].id, 1U);
  EXPECT_EQ(frame.tracks[0].state, TrackState::kConfirmed);
  EXPECT_TRUE(frame.ended.empty());
}

// The camera turns before the object is detected again.
TEST(StereoTracker, PlacesTheMaskOfAJoinedObjectByItsPrediction) {
  TrackerScene scene;
  miss_in_view(scene, kMissedFrames + 5);
  scene.detected = {true};
  scene.object_predictions.assign(2, prediction_of(kCar));
  scene.step(std::array{kCar});
  ASSERT_EQ(scene.frame().tracks.size(), 2U);
  scene.tracker().merge_tracks(scene.frame().tracks[0].slot, scene.frame().tracks[1].slot);
  for (int i = 1; i <= 4; ++i) {
    const Shape expected = shifted(kCar, 20.0 * i);
    scene.object_predictions.assign(2, prediction_of(expected));
    const TrackFrame& frame = scene.step({});
    ASSERT_EQ(frame.tracks.size(), 1U);
    EXPECT_NEAR(frame.tracks[0].box_px.center_x(), expected.x, 2.0) << i;
  }
}

TEST(StereoTracker, ForgetsItsTracksButNotItsIdsOnReset) {
  TrackerScene scene;
  scene.step(std::array{kCar});
  scene.tracker().reset();
  const TrackFrame& frame = scene.step(std::array{kCar});
  ASSERT_EQ(frame.tracks.size(), 1U);
  EXPECT_EQ(frame.tracks[0].id, 2U);
  EXPECT_TRUE(frame.ended.empty());
}

TEST(StereoTracker, RefusesMasksOfAnotherSize) {
  TrackerScene scene;
  std::vector<std::uint8_t> pixels(100);
  DetectionFrame frame;
  frame.available = true;
  frame.left_labels = {pixels.data(), 10, 10, 10};
  const auto result = scene.tracker().process(scene.next_timestamp_ns(), frame, {});
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(result.error().message, HasSubstr("10x10"));
}

TEST(StereoTracker, RefusesMoreDetectionsThanLabels) {
  TrackerScene scene;
  const std::vector<Detection> many(kMaxObjects + 1);
  DetectionFrame frame;
  frame.available = true;
  frame.left = many;
  EXPECT_EQ(scene.tracker().process(scene.next_timestamp_ns(), frame, {}).error().code, ErrorCode::kInvalidArgument);
}

TEST(StereoTracker, NamesTheKeyThatIsOutOfRange) {
  Arena arena(1U << 20U);
  TrackerConfig config;
  config.max_objects = 65;
  const auto result = StereoTracker::create(config, kWidth, kHeight, arena);
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code, ErrorCode::kInvalidConfig);
  EXPECT_EQ(result.error().message, "tracking.max_objects must be in [1, 64], got 65");
  EXPECT_FALSE(StereoTracker::create({}, 0, kHeight, arena).has_value());
}

TEST(StereoTracker, NeedsExactlyTheBytesItAnnounces) {
  const std::size_t bytes = StereoTracker::required_bytes({}, kWidth, kHeight);
  Arena enough(bytes);
  EXPECT_TRUE(StereoTracker::create({}, kWidth, kHeight, enough).has_value());
  EXPECT_EQ(enough.used_bytes(), bytes);
  Arena too_small(bytes - 1);
  EXPECT_EQ(StereoTracker::create({}, kWidth, kHeight, too_small).error().code, ErrorCode::kCapacity);
}

}  // namespace
}  // namespace kinetrace::tracking

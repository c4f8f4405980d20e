// Association of detections with tracks, and prediction of masks.
#include <map>

#include <gtest/gtest.h>

#include "mask_scene.hpp"

namespace kinetrace::tracking {
namespace {

TEST(StereoTracker, SaysWhetherItsDetectionMovesAndNothingWithoutOne) {
  TrackerScene scene;
  const Shape car{.x = 100.0, .y = 100.0};
  for (const bool moving : {false, true, true, false, true}) {
    scene.moving = moving;
    EXPECT_EQ(scene.step(std::array{car}).tracks[0].detected_moving, moving);
  }
  scene.detected = {false};
  EXPECT_FALSE(scene.step(std::array{car}).tracks[0].detected_moving);
}

TEST(StereoTracker, KeepsTheIdOfAnOncomingObjectThatGrowsTenPercentAFrame) {
  TrackerScene scene;
  scene.feature_noise_px = 0.3;
  Shape car{.x = 250.0, .y = 110.0, .half_width = 12.0, .half_height = 9.0, .ellipse = true};
  for (int i = 0; i < 18; ++i) {
    scene.step(std::array{car});
    ASSERT_EQ(scene.frame().tracks.size(), 1U);
    EXPECT_EQ(scene.frame().tracks[0].id, 1U);
    car.half_width *= 1.1;
    car.half_height *= 1.1;
    car.x += 4.0;
  }
  EXPECT_EQ(scene.tracker().counters().born, 1U);
}

TEST(StereoTracker, BridgesMissedDetectionsOfAGrowingObject) {
  TrackerScene scene;
  scene.feature_noise_px = 0.3;
  Shape car{.x = 200.0, .y = 110.0, .half_width = 20.0, .half_height = 14.0, .ellipse = true};
  for (int i = 0; i < 10; ++i) {
    scene.detected = {i < 4};
    scene.step(std::array{car});
    ASSERT_EQ(scene.frame().tracks.size(), 1U);
    EXPECT_GE(scene.left_iou(scene.frame().tracks[0], 0), 0.9) << "frame " << i;
    car.half_width *= 1.1;
    car.half_height *= 1.1;
    car.x += 6.0;
    car.y += 1.5;
  }
  EXPECT_EQ(scene.frame().tracks[0].id, 1U);
  EXPECT_EQ(scene.frame().tracks[0].state, TrackState::kPropagated);
}

// An object that would fill the image is detected: its prediction must not take the background from the camera's pose.
TEST(StereoTracker, LeavesHalfOfTheImageToTheBackgroundWhateverItPredicts) {
  TrackerScene scene;
  Shape car{.x = 320.0, .y = 120.0, .half_width = 140.0, .half_height = 60.0};
  int largest_px = 0;
  for (int i = 0; i < 12; ++i) {
    scene.detected = {i < 4};
    scene.step(std::array{car});
    if (i >= 4) {
      largest_px = std::max(largest_px, area_of(scene.frame().left_labels, 1));
    }
    car.half_width *= 1.1;
    car.half_height *= 1.1;
  }
  EXPECT_GT(largest_px, kWidth * kHeight / 3);
  EXPECT_LE(largest_px, kWidth * kHeight / 2);
}

TEST(StereoTracker, BridgesMissedDetectionsWithTwoFeatures) {
  TrackerScene scene({}, 2);
  Shape car{.x = 200.0, .y = 110.0, .half_width = 40.0, .half_height = 30.0};
  for (int i = 0; i < 9; ++i) {
    scene.detected = {i < 4};
    scene.step(std::array{car});
    ASSERT_EQ(scene.frame().tracks.size(), 1U);
    EXPECT_GE(scene.left_iou(scene.frame().tracks[0], 0), 0.9) << "frame " << i;
    car.x += 15.0;
  }
}

TEST(StereoTracker, BridgesMissedDetectionsByTheLastMotionWithoutFeatures) {
  TrackerScene scene({}, 0);
  Shape car{.x = 100.0, .y = 110.0, .half_width = 40.0, .half_height = 30.0};
  for (int i = 0; i < 11; ++i) {
    scene.detected = {i < 6};
    scene.step(std::array{car});
    ASSERT_EQ(scene.frame().tracks.size(), 1U);
    EXPECT_EQ(scene.frame().tracks[0].id, 1U);
    EXPECT_GE(scene.left_iou(scene.frame().tracks[0], 0), 0.85) << "frame " << i;
    car.x += 12.0;
    car.half_width *= 1.03;
    car.half_height *= 1.03;
  }
}

/// Frames until the predicted mask of a car counts as lost, after 20 frames of which every `nth` has no detection.
int frames_to_lose_its_mask(int nth) {
  constexpr Shape kCar{.x = 100.0, .y = 100.0};
  TrackerScene scene;
  for (int i = 1; i <= 20; ++i) {
    scene.detected = {i % nth != 0};
    scene.step(std::array{kCar});
  }
  scene.detected = {true};
  EXPECT_FALSE(scene.step(std::array{kCar}).tracks[0].mask_lost);
  scene.available = false;
  EXPECT_FALSE(scene.step(std::array{kCar}).tracks[0].mask_lost) << "it was not searched for";
  scene.available = true;
  scene.detected = {false};
  int frames = 1;
  while (!scene.step(std::array{kCar}).tracks[0].mask_lost && frames < 10) {
    ++frames;
  }
  return frames;
}

TEST(StereoTracker, LosesTheMaskOfAReliablyDetectedObjectSooner) {
  EXPECT_EQ(frames_to_lose_its_mask(100), 2);
  EXPECT_EQ(frames_to_lose_its_mask(2), 5) << "half of its frames had no detection";
}

TEST(StereoTracker, BridgesThemAsItsPredictionsWentOnceThereIsNone) {
  TrackerScene scene({}, 0);
  Shape car{.x = 200.0, .y = 100.0};
  const auto step = [&](double dx) {
    car.x += dx;
    scene.object_predictions = {{.known = true, .point_px = {car.x, car.y}, .depth_m = 10.0}};
    scene.step(std::array{car});
  };
  for (int i = 0; i < 4; ++i) {
    step(0.0);
  }
  for (int i = 0; i < 4; ++i) {
    step(12.0);
  }
  scene.object_predictions.clear();
  scene.detected = {false};
  car.x += 12.0;
  scene.step(std::array{car});
  ASSERT_EQ(scene.frame().tracks.size(), 1U);
  EXPECT_GT(scene.left_iou(scene.frame().tracks[0], 0), 0.95);
}

/// Thirty features on the mask of track 1, each moved by `motion_px` of its index.
template <typename Motion>
std::vector<Feature> features_on_mask(const Motion& motion_px) {
  std::vector<Feature> features(30);
  for (std::size_t i = 0; i < features.size(); ++i) {
    Feature& f = features[i];
    f.id = static_cast<std::uint32_t>(i + 1);
    f.age_frames = 3;
    f.body = 1;
    const std::size_t row = i / 8;
    f.previous_left_px = {120.F + 8.F * static_cast<float>(i % 8), 90.F + 9.F * static_cast<float>(row)};
    f.left_px = f.previous_left_px + motion_px(i);
  }
  return features;
}

TEST(StereoTracker, FollowsItsFeaturesDespiteForeignOnesOnItsMask) {
  TrackerScene scene;
  Shape car{.x = 150.0, .y = 110.0, .half_width = 40.0, .half_height = 30.0};
  scene.step(std::array{car});
  scene.step(std::array{car});
  car.x += 12.0;
  // A third of the features on the mask belong to the static background behind it.
  const std::vector<Feature> features =
      features_on_mask([](std::size_t i) { return Eigen::Vector2f(i % 3 == 0 ? 0.F : 12.F, 0.F); });
  const TrackFrame frame = scene.tracker().process(scene.next_timestamp_ns(), {}, features).value();
  Labels truth;
  truth.draw(car, 1);
  EXPECT_GE(mask_iou(frame.left_labels, 1, std::as_const(truth).view(), 1), 0.97);
}

TEST(StereoTracker, FeaturesNearerThanAnObjectDoNotMoveItsMask) {
  TrackerScene scene;
  Shape car{.x = 150.0, .y = 110.0, .half_width = 40.0, .half_height = 30.0};
  scene.step(std::array{car});
  scene.step(std::array{car});
  car.x += 12.0;
  // Two thirds of the features on the mask belong to a standing object in front of it.
  const auto is_own = [](std::size_t i) { return i % 3 == 0; };
  std::vector<Feature> features =
      features_on_mask([&](std::size_t i) { return Eigen::Vector2f(is_own(i) ? 12.F : 0.F, 0.F); });
  for (std::size_t i = 0; i < features.size(); ++i) {
    const double disparity_px = is_own(i) ? car.disparity_px : 2.0 * car.disparity_px;
    features[i].u_right_px = features[i].left_px.x() - static_cast<float>(disparity_px);
  }
  const std::array predictions{ObjectPrediction{.known = true,
                                                .point_px = {car.x, car.y},
                                                .depth_m = 20.0,
                                                .disparity_px = car.disparity_px,
                                                .disparity_sigma_px = 0.5}};
  const TrackFrame frame = scene.tracker().process(scene.next_timestamp_ns(), {}, features, predictions).value();
  Labels truth;
  truth.draw(car, 1);
  EXPECT_GE(mask_iou(frame.left_labels, 1, std::as_const(truth).view(), 1), 0.97);
}

TEST(StereoTracker, KeepsIdsWhenDetectionLabelsAreShuffled) {
  TrackerScene scene;
  std::vector<Shape> shapes;
  shapes.reserve(4);
  for (int k = 0; k < 4; ++k) {
    shapes.push_back({.x = 80.0 + 130.0 * k, .y = 60.0 + 40.0 * k, .disparity_px = 8.0 + k, .ellipse = k % 2 == 0});
  }
  std::array<std::uint32_t, 4> first_id{};
  for (int i = 0; i < 12; ++i) {
    scene.label_order = {1, 2, 3, 4};
    std::rotate(scene.label_order.begin(), scene.label_order.begin() + i % 4, scene.label_order.end());
    scene.step(shapes);
    ASSERT_EQ(scene.frame().tracks.size(), 4U);
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      const Track* track = scene.track_of(k);
      ASSERT_NE(track, nullptr);
      first_id[k] = i == 0 ? track->id : first_id[k];
      EXPECT_EQ(track->id, first_id[k]);
      EXPECT_EQ(scene.left_iou(*track, k), 1.0);
      shapes[k].x += 3.0 - 2.0 * static_cast<double>(k);
    }
  }
}

TEST(StereoTracker, KeepsTheIdsOfCrossingObjects) {
  TrackerScene scene;
  Shape near{.x = 120.0, .y = 110.0, .half_width = 45.0, .half_height = 40.0, .disparity_px = 30.0};
  Shape far{.x = 420.0, .y = 100.0, .half_width = 35.0, .half_height = 25.0, .disparity_px = 15.0, .ellipse = true};
  int hidden_frames = 0;
  std::uint32_t near_id = 0;
  std::uint32_t far_id = 0;
  for (int i = 0; i < 40; ++i) {
    scene.step(std::array{near, far});
    const Track* front = scene.track_of(0);
    ASSERT_NE(front, nullptr);
    EXPECT_EQ(scene.left_iou(*front, 0), 1.0);
    near_id = i == 0 ? front->id : near_id;
    far_id = i == 0 ? scene.track_of(1)->id : far_id;
    near.x += 8.0;
    far.x -= 6.0;
    hidden_frames += area_of(scene.truth_left(), 2) == 0 ? 1 : 0;
  }
  EXPECT_GT(hidden_frames, 0) << "the scene is meant to hide the far object completely";
  EXPECT_EQ(scene.tracker().counters().born, 2U);
  ASSERT_NE(scene.track_of(1), nullptr);
  EXPECT_EQ(scene.track_of(0)->id, near_id);
  EXPECT_EQ(scene.track_of(1)->id, far_id);
  EXPECT_EQ(scene.track_of(1)->state, TrackState::kConfirmed);
}

TEST(StereoTracker, KeepsTheLargestPartOfASplitDetectionAndToleratesNoDuplicate) {
  TrackerScene scene({}, 0);
  const Shape whole{.x = 200.0, .y = 100.0, .half_width = 60.0, .half_height = 30.0};
  for (int i = 0; i < 3; ++i) {
    scene.step(std::array{whole});
  }
  Shape big = whole;
  big.half_width = 40.0;
  big.x -= 20.0;
  Shape small = whole;
  small.half_width = 15.0;
  small.x += 45.0;
  const TrackFrame& frame = scene.step(std::array{big, small});
  ASSERT_EQ(frame.tracks.size(), 1U);
  EXPECT_EQ(frame.tracks[0].id, 1U);
  EXPECT_EQ(scene.left_iou(frame.tracks[0], 0), 1.0);
  EXPECT_EQ(scene.tracker().counters().detections_duplicate, 1U);
  EXPECT_EQ(area_of(frame.left_labels, kIgnoreLabel), scene.detections().left[1].area_px);
}

TEST(StereoTracker, ToleratesAPersonInFrontOfATrackedVehicle) {
  TrackerScene scene;
  const Shape truck{.x = 200.0, .y = 100.0, .half_width = 90.0, .half_height = 60.0, .disparity_px = 12.0};
  for (int i = 0; i < 3; ++i) {
    scene.step(std::array{truck});
  }
  const Shape person{.x = 210.0,
                     .y = 120.0,
                     .half_width = 10.0,
                     .half_height = 30.0,
                     .disparity_px = 20.0,
                     .class_id = kPedestrianClass};
  EXPECT_EQ(scene.step(std::array{truck, person}).tracks.size(), 2U);
}

TEST(StereoTracker, ToleratesANearerObjectOfUnknownClassInFrontOfATrackedOne) {
  TrackerScene scene;
  Shape truck{.x = 200.0, .y = 100.0, .half_width = 90.0, .half_height = 60.0, .disparity_px = 12.0};
  truck.class_id = kUnknownClass;
  Shape bicycle{.x = 210.0, .y = 120.0, .half_width = 12.0, .half_height = 30.0, .disparity_px = 20.0};
  bicycle.class_id = kUnknownClass;
  scene.detected = {true, false};
  for (int i = 0; i < 3; ++i) {
    scene.step(std::array{truck, bicycle});
  }
  scene.detected = {true, true};
  EXPECT_EQ(scene.step(std::array{truck, bicycle}).tracks.size(), 2U);
}

TEST(StereoTracker, TakesTheClassThatMostDetectionsHad) {
  TrackerScene scene;
  Shape car{.x = 200.0, .y = 100.0};
  for (const std::uint16_t class_id : {kUnknownClass, kPedestrianClass, kVehicleClass, kUnknownClass, kVehicleClass}) {
    car.class_id = class_id;
    scene.step(std::array{car});
  }
  EXPECT_EQ(scene.frame().tracks[0].class_id, kVehicleClass);
}

TEST(StereoTracker, HasTheClassOfBothAfterJoining) {
  for (const bool was_known : {true, false}) {
    TrackerScene scene;
    Shape earlier{.x = 150.0, .y = 120.0};
    Shape later{.x = 450.0, .y = 120.0};
    (was_known ? later : earlier).class_id = kUnknownClass;
    for (int i = 0; i < 3; ++i) {
      scene.step(std::array{earlier});
    }
    scene.detected = {false, true};
    scene.step(std::array{earlier, later});
    ASSERT_EQ(scene.frame().tracks.size(), 2U);
    scene.tracker().merge_tracks(scene.frame().tracks[0].slot, scene.frame().tracks[1].slot);
    ASSERT_EQ(scene.tracker().tracks().size(), 1U);
    EXPECT_EQ(scene.tracker().tracks()[0].class_id, kVehicleClass) << was_known;
  }
}

TEST(StereoTracker, PassesIgnoredPixelsOn) {
  TrackerScene scene;
  const Shape car{.x = 200.0, .y = 100.0};
  scene.step(std::array{car});
  DetectionFrame detections = scene.detections();
  Labels with_ignored = scene.left_labels();
  with_ignored.draw({.x = 500.0, .y = 50.0}, kIgnoreLabel);
  detections.left_labels = std::as_const(with_ignored).view();
  const TrackFrame frame = scene.tracker().process(scene.next_timestamp_ns(), detections, {}).value();
  EXPECT_EQ(area_of(frame.left_labels, kIgnoreLabel), area_of(std::as_const(with_ignored).view(), kIgnoreLabel));
  EXPECT_EQ(area_of(frame.left_labels, 1), detections.left[0].area_px);
}

TEST(StereoTracker, ShowsOnlyTheUnassignedPartOfAPropagatedTrack) {
  TrackerScene scene;
  const Shape hidden{.x = 200.0, .y = 100.0, .disparity_px = 10.0};
  const Shape front{.x = 240.0, .y = 100.0, .disparity_px = 20.0};
  for (int i = 0; i < 3; ++i) {
    scene.step(std::array{hidden, front});
  }
  scene.detected = {false, true};
  scene.step(std::array{hidden, front});
  ASSERT_EQ(scene.frame().tracks.size(), 2U);
  for (const std::size_t k : {0U, 1U}) {
    const Track* track = scene.track_of(k);
    ASSERT_NE(track, nullptr);
    EXPECT_EQ(scene.left_iou(*track, k), 1.0);
    EXPECT_EQ(track->state, k == 0 ? TrackState::kPropagated : TrackState::kConfirmed);
    EXPECT_EQ(area_of(scene.frame().left_labels, track->label()), track->area_px);
  }
}

TEST(StereoTracker, DerivesTheRightMaskFromTheDisparity) {
  TrackerScene scene;
  const std::array shapes{Shape{.x = 200.0, .y = 100.0, .disparity_px = 17.0},
                          Shape{.x = 250.0, .y = 110.0, .disparity_px = 40.0, .ellipse = true}};
  scene.step(shapes);
  scene.step(shapes);
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    const Track* track = scene.track_of(k);
    ASSERT_NE(track, nullptr);
    EXPECT_GE(scene.right_iou(*track, k), 0.95);
  }
}

TEST(StereoTracker, HasNoRightMaskWithoutDisparity) {
  TrackerScene scene({}, 0);
  scene.step(std::array{Shape{.x = 200.0, .y = 100.0}});
  EXPECT_EQ(area_of(scene.frame().right_labels, 1), 0);
}

TEST(StereoTracker, AttachesTheRightDetectionAndNotTheDistractorBesideIt) {
  TrackerScene scene;
  scene.with_right = true;
  // The distractor lies where the object would be at another disparity, and only the right image shows it.
  const Shape car{.x = 300.0, .y = 100.0, .half_width = 30.0, .half_height = 20.0, .disparity_px = 40.0};
  Shape distractor = car;
  distractor.x = 345.0;
  scene.step(std::array{car});
  scene.step(std::array{car});
  Labels right;
  right.draw(car, 2, car.disparity_px);
  right.draw(distractor, 1, car.disparity_px);
  const auto right_detections = measure_detections(std::as_const(right).view(), std::array<std::uint8_t, 2>{1, 2},
                                                   std::array<std::uint16_t, 2>{kVehicleClass, kVehicleClass});
  DetectionFrame detections = scene.detections();
  detections.right_labels = std::as_const(right).view();
  detections.right = right_detections;
  const TrackFrame frame = scene.tracker().process(scene.next_timestamp_ns(), detections, {}).value();
  ASSERT_EQ(frame.tracks.size(), 1U);
  EXPECT_EQ(mask_iou(frame.right_labels, frame.tracks[0].label(), std::as_const(right).view(), 2), 1.0);
  EXPECT_GT(area_of(frame.right_labels, kIgnoreLabel), 0);
}

TEST(StereoTracker, GivesTheSameResultForTheSameInput) {
  std::array<std::vector<std::uint8_t>, 2> images;
  for (std::vector<std::uint8_t>& image : images) {
    TrackerScene scene;
    scene.feature_noise_px = 1.0;
    Shape car{.x = 150.0, .y = 100.0, .ellipse = true};
    for (int i = 0; i < 8; ++i) {
      scene.detected = {i % 3 != 2};
      scene.step(std::array{car});
      car.x += 7.3;
      car.half_width *= 1.04;
      for (int y = 0; y < kHeight; ++y) {
        image.insert(image.end(), scene.frame().left_labels.row(y), scene.frame().left_labels.row(y) + kWidth);
        image.insert(image.end(), scene.frame().right_labels.row(y), scene.frame().right_labels.row(y) + kWidth);
      }
    }
  }
  EXPECT_EQ(images[0], images[1]);
}

}  // namespace
}  // namespace kinetrace::tracking

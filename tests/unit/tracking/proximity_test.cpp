// Detections without overlap with a prediction: objects that move by more than their width, and first visible parts of
// objects that emerge from an occlusion.
#include <array>
#include <span>

#include <gtest/gtest.h>

#include "mask_scene.hpp"

namespace kinetrace::tracking {
namespace {

constexpr Shape kPerson{
    .x = 100.0, .y = 100.0, .half_width = 5.0, .half_height = 20.0, .disparity_px = 8.0, .class_id = kPedestrianClass};

ObjectPrediction prediction_of(const Shape& shape) {
  return {.known = true, .point_px = {shape.x, shape.y}, .depth_m = 100.0 / shape.disparity_px};
}

/// Four frames at one place without features, then one at another.
const Track* slip(TrackerScene& scene, const Shape& there, const Shape& shape = kPerson) {
  for (int i = 0; i < 4; ++i) {
    scene.step(std::array{shape});
  }
  scene.step(std::array{there});
  return scene.track_of(0);
}

Shape moved(Shape shape, double dx) {
  shape.x += dx;
  return shape;
}

TEST(ProximityPair, SomethingThinMayMoveByMoreThanItsWidth) {
  for (const double dx : {12.0, -12.0, 18.0}) {
    TrackerScene scene({}, 0);
    const Track* track = slip(scene, moved(kPerson, dx));
    ASSERT_NE(track, nullptr) << dx;
    EXPECT_EQ(track->id, 1U) << dx;
    EXPECT_GT(scene.left_iou(*track, 0), 0.99) << dx;
  }
}

TEST(ProximityPair, NotByMoreThanPartOfItsSize) {
  TrackerScene scene({}, 0);
  const Track* track = slip(scene, moved(kPerson, 30.0));
  ASSERT_NE(track, nullptr);
  EXPECT_EQ(track->id, 2U);
}

TEST(ProximityPair, NothingOfAnotherClassOrAnotherSize) {
  Shape vehicle = moved(kPerson, 20.0);
  vehicle.class_id = kVehicleClass;
  Shape large = moved(kPerson, 24.0);
  large.half_width = 12.0;
  for (const Shape& other : {vehicle, large}) {
    TrackerScene scene({}, 0);
    const Track* track = slip(scene, other);
    ASSERT_NE(track, nullptr);
    EXPECT_EQ(track->id, 2U);
  }
}

TEST(ProximityPair, EachOfTwoNeighboursKeepsItsName) {
  TrackerScene scene({}, 0);
  const Shape right = moved(kPerson, 40.0);
  for (int i = 0; i < 4; ++i) {
    scene.step(std::array{kPerson, right});
  }
  scene.step(std::array{moved(kPerson, 13.0), moved(right, 13.0)});
  ASSERT_NE(scene.track_of(0), nullptr);
  ASSERT_NE(scene.track_of(1), nullptr);
  EXPECT_EQ(scene.track_of(0)->id, 1U);
  EXPECT_EQ(scene.track_of(1)->id, 2U);
}

/// A parked car, passed by a nearer van that occludes all of it for some frames; then a first part of it emerges.
class BehindAVan : public ::testing::Test {
 protected:
  static constexpr Shape kParked{.x = 300.0, .y = 100.0, .disparity_px = 6.0};
  static constexpr Shape kVan{.x = 0.0, .y = 100.0, .half_width = 60.0, .half_height = 45.0, .disparity_px = 20.0};

  void step(double van_x) {
    Shape van = kVan;
    van.x = van_x;
    scene_.object_predictions = {prediction_of(van), prediction_of(kParked)};  // The larger is born first.
    scene_.step(std::array{kParked, van});
  }
  TrackerScene scene_;
};

TEST_F(BehindAVan, TheFirstBitThatComesOutHasTheOldName) {
  for (int x = 60; x <= 345; x += 15) {
    step(x);
    if (x == 285) {
      EXPECT_EQ(scene_.track_of(0), nullptr) << "all of it is hidden";
    }
  }
  const Track* track = scene_.track_of(0);
  ASSERT_NE(track, nullptr);
  EXPECT_EQ(track->id, 2U);
  EXPECT_LT(track->area_px, 61 * 41 / 2) << "most of it is still hidden";
}

TEST_F(BehindAVan, TheFirstBitMayComeOutBesideWhereItWasExpected) {
  for (int x = 60; x <= 345; x += 15) {
    Shape van = kVan;
    van.x = x;
    van.half_height = 90.0;
    Shape expected = kParked;
    expected.y += x > 270 ? 45.0 : 0.0;  // While occluded it is predicted to approach, and known to be uncertain.
    scene_.object_predictions = {prediction_of(van), prediction_of(expected)};
    scene_.object_predictions[1].extent = extent_of(expected, 30.0);
    scene_.step(std::array{kParked, van});
  }
  const Track* track = scene_.track_of(0);
  ASSERT_NE(track, nullptr);
  EXPECT_EQ(track->id, 2U);
}

TEST(ProximityPair, APartOfAThingInViewIsThatThing) {
  Shape car{.x = 300.0, .y = 100.0, .disparity_px = 6.0};
  Shape part = car;
  part.x += 29.0;
  part.y += 9.0;
  part.half_width = 12.0;
  part.half_height = 12.0;
  TrackerScene scene({}, 0);
  const Track* track = slip(scene, part, car);
  ASSERT_NE(track, nullptr);
  EXPECT_EQ(track->id, 1U);
}

TEST(ProximityPair, WhatHasNearlyLeftTheImageSlipsOntoNothing) {
  TrackerScene scene({}, 0);
  const auto step = [&](double car_x, std::span<const Shape> shapes) {
    const Shape car{.x = car_x, .y = 100.0};
    scene.object_predictions = {prediction_of(car)};
    scene.step(shapes);
  };
  for (const double x : {60.0, 40.0, 20.0, 0.0}) {
    step(x, std::array{Shape{.x = x, .y = 100.0}});
  }
  step(-20.0, std::array{Shape{.x = 60.0, .y = 100.0, .half_width = 8.0}});
  ASSERT_NE(scene.track_of(0), nullptr);
  EXPECT_EQ(scene.track_of(0)->id, 2U) << "another one stands where it went";
}

/// Id of a detection at the border while a car leaves over the left border and is predicted just outside.
std::uint32_t id_at_border(const Shape& strip) {
  TrackerScene scene({}, 0);
  const auto step = [&](double car_x, const Shape& seen) {
    scene.object_predictions = {prediction_of({.x = car_x, .y = 100.0})};
    scene.step(std::array{seen});
  };
  for (const double x : {60.0, 40.0, 20.0, 0.0, -20.0}) {
    step(x, {.x = x, .y = 100.0});
  }
  step(-40.0, strip);
  return scene.track_of(0) == nullptr ? 0 : scene.track_of(0)->id;
}

TEST(ProximityPair, AStripAtTheBorderIsWhatWasExpectedJustOutside) {
  const Shape strip{.x = 3.0, .y = 100.0, .half_width = 4.0};
  EXPECT_EQ(id_at_border(strip), 1U);
  Shape of_another_height = strip;
  of_another_height.half_height = 7.0;
  EXPECT_EQ(id_at_border(of_another_height), 2U);
  Shape elsewhere = strip;
  elsewhere.y = 140.0;
  EXPECT_EQ(id_at_border(elsewhere), 2U);
  Shape no_strip = strip;
  no_strip.half_width = 40.0;
  EXPECT_EQ(id_at_border(no_strip), 2U);
  EXPECT_EQ(id_at_border(moved(strip, 60.0)), 2U) << "not at the border";
  EXPECT_EQ(id_at_border(moved(strip, kWidth - 6.0)), 2U) << "at the other border";
}

/// Id of the next frame's detection of an object whose first mask was a strip along the border.
std::uint32_t id_after_strip(const Shape& strip, const Shape& next) {
  TrackerScene scene({}, 0);
  const Track* track = slip(scene, next, strip);
  return track == nullptr ? 0 : track->id;
}

TEST(ProximityPair, AStripAtTheBorderComesFurtherIn) {
  const Shape above{.x = 300.0, .y = 0.0, .half_width = 12.0, .half_height = 2.0};
  const Shape below{.x = 300.0, .y = kHeight - 1.0, .half_width = 12.0, .half_height = 2.0};
  const Shape left{.x = 0.0, .y = 100.0, .half_width = 2.0, .half_height = 12.0};
  const Shape right{.x = kWidth - 1.0, .y = 100.0, .half_width = 2.0, .half_height = 12.0};
  for (const Shape& strip : {above, below, left, right}) {
    const auto reaches = [&](double reach_px) {
      Shape next = strip;
      (strip.half_width < strip.half_height ? next.half_width : next.half_height) = reach_px;
      return next;
    };
    EXPECT_EQ(id_after_strip(strip, reaches(20.0)), 1U) << strip.x << ' ' << strip.y;
    EXPECT_EQ(id_after_strip(strip, reaches(34.0)), 2U) << "too far, " << strip.x << ' ' << strip.y;
    Shape beside = reaches(20.0);
    (strip.half_width < strip.half_height ? beside.y : beside.x) += 14.0;
    EXPECT_EQ(id_after_strip(strip, beside), 2U) << "beside it, " << strip.x << ' ' << strip.y;
  }
}

/// Id of a detection beside an undetected person, after four frames.
std::uint32_t id_beside(TrackerScene& scene, const ObjectPrediction& prediction, double beside_px = 14.0) {
  for (int i = 0; i < 4; ++i) {
    scene.object_predictions = {prediction_of(kPerson)};
    scene.step(std::array{kPerson});
  }
  scene.object_predictions = {prediction};
  scene.detected = {false, true};
  scene.step(std::array{kPerson, moved(kPerson, beside_px)});
  return scene.track_of(1) == nullptr ? 0 : scene.track_of(1)->id;
}

TEST(ProximityPair, WhereNoneOfItsFeaturesHasGoneIsAnother) {
  TrackerScene none({}, 0);
  EXPECT_EQ(id_beside(none, prediction_of(kPerson)), 1U);
  for (const int features : {24, 60}) {
    TrackerScene scene({}, features);
    EXPECT_EQ(id_beside(scene, prediction_of(kPerson)), 2U) << features;
  }
}

TEST(ProximityPair, FewFeaturesThatStayBehindDoNotHoldAnybody) {
  // A thin person walks on, and three features stay on the background.
  const auto id_after = [](double step_px, const ObjectPrediction& prediction) {
    TrackerScene scene({}, 3);
    return id_beside(scene, prediction, step_px);
  };
  EXPECT_EQ(id_after(14.0, prediction_of(moved(kPerson, 12.0))), 1U) << "expected there";
  EXPECT_EQ(id_after(24.0, prediction_of(kPerson)), 2U);
}

TEST(ProximityPair, WhatIsAtAnotherDepthIsAnother) {
  const auto id_at = [](double disparity_px) {
    TrackerScene scene({}, 8);
    Shape beside = moved(kPerson, 14.0);
    beside.disparity_px = disparity_px;
    scene.detected = {true, false};
    for (int i = 0; i < 4; ++i) {
      scene.object_predictions = {prediction_of(kPerson)};
      scene.step(std::array{kPerson, beside});
    }
    scene.object_predictions = {prediction_of(moved(kPerson, 12.0))};
    scene.detected = {false, true};
    scene.step(std::array{kPerson, beside});
    return scene.track_of(1) == nullptr ? 0 : scene.track_of(1)->id;
  };
  EXPECT_EQ(id_at(kPerson.disparity_px), 1U);
  EXPECT_EQ(id_at(kPerson.disparity_px + 4.0), 2U) << "nearer";
  EXPECT_EQ(id_at(kPerson.disparity_px - 4.0), 2U) << "farther away";
}

TEST(ProximityPair, WhatIsBehindTheCameraByNowIsNotBesideIt) {
  TrackerScene scene({}, 3);
  ObjectPrediction behind = prediction_of(kPerson);
  behind.depth_m = -0.5;
  EXPECT_EQ(id_beside(scene, behind), 2U);
}

TEST(ProximityPair, ADirectionBehindTheCameraIsNotInTheImage) {
  // The opposite direction projects to the same pixel.
  TrackerScene scene({}, 0);
  const auto step = [&](double depth_m, bool visible) {
    scene.object_predictions = {
        {.known = true, .point_px = {kPerson.x, kPerson.y}, .depth_m = depth_m, .direction_only = true}};
    scene.detected = {visible};
    scene.step(std::array{kPerson});
  };
  for (int i = 0; i < 4; ++i) {
    step(1000.0, true);
  }
  for (int i = 0; i < 4; ++i) {
    step(-1000.0, false);
  }
  step(-1000.0, true);
  ASSERT_NE(scene.track_of(0), nullptr);
  EXPECT_EQ(scene.track_of(0)->id, 2U);
}

constexpr Shape kPassing{.x = 60.0, .y = 120.0, .half_width = 60.0, .half_height = 60.0};

ObjectPrediction at_depth(const Shape& shape, double depth_m) {
  return {.known = true, .point_px = {shape.x, shape.y}, .depth_m = depth_m};
}

/// Id of an object that passes close by, without features, after its prediction has changed from `before` to
/// `prediction` and it was missed for `missed` frames.
std::uint32_t id_in_passing(const ObjectPrediction& prediction, int missed,
                            const ObjectPrediction& before = at_depth(kPassing, 0.5)) {
  TrackerScene scene({}, 0);
  for (int i = 0; i < 4; ++i) {
    scene.object_predictions = {before};
    scene.step(std::array{kPassing});
  }
  for (int i = 0; i <= missed; ++i) {
    scene.object_predictions = {prediction};
    scene.detected = {i == missed};
    scene.step(std::array{kPassing});
  }
  return scene.track_of(0) == nullptr ? 0 : scene.track_of(0)->id;
}

TEST(ProximityPair, WhatPassesByIsWhereItWasAMomentAgo) {
  EXPECT_EQ(id_in_passing(at_depth(kPassing, 0.1), 0), 1U) << "too near for a prediction";
  EXPECT_EQ(id_in_passing(at_depth(kPassing, -0.3), 0), 1U) << "its middle is behind the camera";
  EXPECT_EQ(id_in_passing(at_depth(moved(kPassing, 300.0), 0.4), 0), 1U) << "expected somewhere else altogether";
}

TEST(ProximityPair, WhatHasPassedByIsNoLongerThere) {
  EXPECT_EQ(id_in_passing(at_depth(kPassing, -0.3), 3), 2U);
  EXPECT_EQ(id_in_passing(at_depth(kPassing, -0.3), 3, at_depth(kPassing, 0.1)), 2U) << "seen too near already";
  EXPECT_EQ(id_in_passing(at_depth(kPassing, -0.3), 3, {}), 2U) << "seen when nothing was expected of it";
}

TEST(ProximityPair, SomebodyInFrontOfACarMaySlip) {
  const Shape car{.x = 100.0, .y = 100.0, .half_width = 60.0, .half_height = 30.0, .disparity_px = 6.0};
  TrackerScene scene({}, 0);
  for (int i = 0; i < 4; ++i) {
    scene.step(std::array{kPerson, car});
  }
  ASSERT_NE(scene.track_of(0), nullptr);
  const std::uint32_t id = scene.track_of(0)->id;
  scene.step(std::array{moved(kPerson, 14.0), car});
  ASSERT_NE(scene.track_of(0), nullptr);
  EXPECT_EQ(scene.track_of(0)->id, id);
}

TEST(ProximityPair, WhatWasSeenBeforeItsDirectionWasKnownGoesWithIt) {
  TrackerScene scene({}, 0);
  for (int i = 0; i < 3; ++i) {
    scene.object_predictions.clear();
    scene.step(std::array{kPerson});
  }
  scene.detected = {false};
  for (int i = 1; i <= 4; ++i) {
    const Shape there = moved(kPerson, 20.0 * i);
    scene.object_predictions = {
        {.known = true, .point_px = {there.x, there.y}, .depth_m = 1000.0, .direction_only = true}};
    scene.step(std::array{there});
  }
  ASSERT_EQ(scene.frame().tracks.size(), 1U);
  EXPECT_GT(scene.left_iou(scene.frame().tracks[0], 0), 0.9);
}

TEST(ProximityPair, WithoutAPlaceItsDirectionWaits) {
  // Far away: only a direction is predicted.
  TrackerScene scene({}, 0);
  const auto step = [&](const Shape& shape, bool visible) {
    scene.object_predictions = {
        {.known = true, .point_px = {shape.x, shape.y}, .depth_m = 1000.0, .direction_only = true}};
    scene.detected = {visible};
    scene.step(std::array{shape});
  };
  for (int i = 0; i < 4; ++i) {
    step(kPerson, true);
  }
  for (int i = 1; i <= 6; ++i) {
    step(moved(kPerson, 20.0 * i), false);
  }
  step(moved(kPerson, 140.0), true);
  ASSERT_NE(scene.track_of(0), nullptr);
  EXPECT_EQ(scene.track_of(0)->id, 1U);
}

TEST(ProximityPair, ADirectionAndAPlaceAreNotCompared) {
  TrackerScene scene({}, 0);
  const auto step = [&](const ObjectPrediction& prediction, bool visible) {
    scene.object_predictions = {prediction};
    scene.detected = {visible};
    scene.step(std::array{kPerson});
  };
  for (int i = 0; i < 4; ++i) {
    step({.known = true, .point_px = {kPerson.x, kPerson.y}, .depth_m = 1000.0, .direction_only = true}, true);
  }
  step(prediction_of(kPerson), false);
  ASSERT_EQ(scene.frame().tracks.size(), 1U);
  EXPECT_GT(scene.left_iou(scene.frame().tracks[0], 0), 0.99) << "as if it had come a hundred times nearer";
}

}  // namespace
}  // namespace kinetrace::tracking

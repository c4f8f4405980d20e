#include <array>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "motion_scene.hpp"

namespace kinetrace::segmentation {
namespace {

/// Ten percent outliers: half of them wrong tracks, half wrong right matches.
test::WorldConfig street(std::uint32_t seed = 1) {
  test::WorldConfig world;
  world.background_features = 700;
  world.wrong_track_ratio = 0.05;
  world.wrong_right_ratio = 0.05;
  world.seed = seed;
  return world;
}

constexpr double kInterval_s = 0.1;

/// A car seen from its side (moving along x) or its front (moving along z), at view height less .6 m.
Se3 car_at(const Eigen::Vector3d& position_m, const Eigen::Vector3d& velocity_mps) {
  return test::turned(std::abs(velocity_mps.x()) > std::abs(velocity_mps.z()) ? 0.0 : 1.5707963, position_m);
}

TEST(MotionSegmenter, FindsNothingInAStaticWorld) {
  for (const double metres_per_frame : {0.0, 0.5, 1.5}) {
    MotionScene scene(street(static_cast<std::uint32_t>(10.0 * metres_per_frame) + 1));
    for (int i = 0; i < 200; ++i) {
      EXPECT_EQ(scene.step(test::driven(metres_per_frame * i, 0.01)).detections, 0U)
          << metres_per_frame << " m a frame, frame " << i;
    }
  }
}

TEST(MotionSegmenter, FindsNothingWhenNothingIsSeen) {
  MotionScene scene(street());
  scene.step({});
  scene.world().observe_nothing();
  SegmentationInput input;
  input.ego_valid = true;
  const DetectionFrame empty = scene.segmenter().process(input).value();
  EXPECT_TRUE(empty.available);
  EXPECT_TRUE(empty.left.empty());
}

TEST(MotionSegmenter, NeverReportsAParkedCar) {
  MotionScene scene(street(), {{{4.0, 1.5, 1.8}, 60}});
  const std::array parked{test::turned(1.5707963, {2.5, 0.8, 25.0})};
  for (int i = 0; i < 40; ++i) {
    EXPECT_EQ(scene.step(test::driven(0.5 * i), parked).detections, 0U) << i;
  }
}

struct Mover {
  const char* name;
  Eigen::Vector3d direction;
  double speed_mps;
  double depth_m;
  int found_by_frame;
  std::size_t most_detections = 1;  ///< Without images, a barely visible object may be two regions at first.
  int found_of_15_scenes = 14;      ///< At least.
};

/// A car's run in one scene, or the sum of several.
struct Finding {
  int in_time = 0;  ///< 1 if it is found in time.
  int frames = 0;
  int split_frames = 0;  ///< In which it is more detections than it may be.
  int empty_frames = 0;  ///< In which a detection holds no feature of it.
};

Finding follow(const Mover& mover, double ego_mps, std::uint32_t seed) {
  const Eigen::Vector3d velocity = mover.speed_mps * mover.direction;
  // As many features as fit on so small an image: one per 12 x 12 pixels or so.
  MotionScene scene(street(seed), {{{4.0, 1.5, 1.8}, static_cast<int>(std::min(60.0, 1600.0 / mover.depth_m))}});
  Finding finding;
  int first = 1000;
  double coverage = 0.0;
  for (int i = 0; i <= mover.found_by_frame + 2; ++i) {
    const Eigen::Vector3d position = Eigen::Vector3d(0.5, 0.6, mover.depth_m) + velocity * kInterval_s * i;
    const SceneScore score =
        scene.step(test::driven(ego_mps * kInterval_s * i), std::array{car_at(position, velocity)});
    ++finding.frames;
    finding.empty_frames += score.empty_detections > 0 ? 1 : 0;
    finding.split_frames += score.detections > mover.most_detections ? 1 : 0;
    if (score.hits[0] > 0) {
      first = std::min(first, i);
      coverage = std::max(coverage, score.coverage[0]);
    }
  }
  finding.in_time = first <= mover.found_by_frame && coverage >= 0.5 ? 1 : 0;
  return finding;
}

class MotionSegmenterFinds : public ::testing::TestWithParam<Mover> {};

// In one scene the last bit of a float may decide, and processors differ in it; they differ little in rates over many.
TEST_P(MotionSegmenterFinds, AMovingCar) {
  for (const double ego_mps : {0.0, 5.0}) {
    Finding sum;
    for (std::uint32_t seed = 1; seed <= 15; ++seed) {
      const Finding finding = follow(GetParam(), ego_mps, seed);
      sum.in_time += finding.in_time;
      sum.frames += finding.frames;
      sum.split_frames += finding.split_frames;
      sum.empty_frames += finding.empty_frames;
    }
    EXPECT_GE(sum.in_time, GetParam().found_of_15_scenes) << "ego " << ego_mps;
    EXPECT_LE(sum.split_frames, sum.frames / 12) << "ego " << ego_mps;
    EXPECT_LE(sum.empty_frames, sum.frames / 60) << "ego " << ego_mps;
  }
}

INSTANTIATE_TEST_SUITE_P(Across, MotionSegmenterFinds,
                         ::testing::Values(Mover{"Walking10m", {1, 0, 0}, 3.0, 10.0, 5, 1, 11},
                                           Mover{"Slow30m", {1, 0, 0}, 3.0, 30.0, 5},
                                           Mover{"Slow40m", {-1, 0, 0}, 3.0, 40.0, 5},
                                           Mover{"Town20m", {1, 0, 0}, 8.0, 20.0, 5},
                                           Mover{"Fast40m", {-1, 0, 0}, 15.0, 40.0, 5}),
                         [](const auto& mover) { return std::string(mover.param.name); });

// Motion along the line of sight shows in depth alone, the later the farther and slower the object is.
INSTANTIATE_TEST_SUITE_P(Along, MotionSegmenterFinds,
                         ::testing::Values(Mover{"Oncoming20m", {0, 0, -1}, 6.0, 20.0, 5},
                                           Mover{"Oncoming40m", {0, 0, -1}, 15.0, 40.0, 5},
                                           Mover{"Leaving20m", {0, 0, 1}, 10.0, 20.0, 5},
                                           Mover{"SlowOncoming20m", {0, 0, -1}, 3.0, 20.0, 8},
                                           Mover{"SlowOncoming30m", {0, 0, -1}, 3.0, 30.0, 12, 2, 10}),
                         [](const auto& mover) { return std::string(mover.param.name); });

TEST(MotionSegmenter, TellsTwoObjectsApart) {
  MotionScene scene(street(), {{{4.0, 1.5, 1.8}, 60}, {{4.0, 1.5, 1.8}, 60}});
  SceneScore score;
  for (int i = 0; i < 10; ++i) {
    const double x = 0.6 * i;
    score = scene.step(test::driven(0.5 * i),
                       std::array{test::turned(0.0, {-8.0 + x, 0.6, 20.0}), test::turned(0.0, {9.0 - x, 0.6, 24.0})});
  }
  EXPECT_EQ(score.detections, 2U);
  EXPECT_THAT(score.hits, ::testing::Each(1U));
}

TEST(MotionSegmenter, GivesOneDetectionForALongTruckWithFeaturesAtItsEnds) {
  // Two boxes move as one: separate in the image, one detection once a tracker has given them one label.
  MotionScene scene(street(), {{{1.0, 2.0, 1.8}, 40}, {{1.0, 2.0, 1.8}, 40}});
  scene.one_body = true;
  SceneScore score;
  for (int i = 0; i < 14; ++i) {
    const double x = -6.0 + 0.5 * i;
    score = scene.step({}, std::array{test::turned(0.0, {x, 0.6, 14.0}), test::turned(0.0, {x + 5.0, 0.6, 14.0})});
  }
  EXPECT_EQ(score.detections, 1U);
}

TEST(MotionSegmenter, KeepsAnObjectThatStopsForAWhile) {
  MotionConfig motion;
  motion.hold_s = 1.2;
  test::WorldConfig world = street();
  world.max_track_frames = 60;
  world.min_track_frames = 40;
  MotionScene scene(world, {{{4.0, 1.5, 1.8}, 60}}, motion);
  double x = -4.0;
  int reported_at_rest = 0;
  int moving = 0;
  for (int i = 0; i < 45; ++i) {
    x += i < 12 ? 0.5 : 0.0;
    const SceneScore score = scene.step({}, std::array{test::turned(0.0, {x, 0.6, 18.0})});
    moving += static_cast<int>(score.moving);
    reported_at_rest += i >= 12 && score.hits[0] > 0 ? 1 : 0;
    if (i < 24 && i >= 5) {
      EXPECT_GT(score.hits[0], 0U) << i;
    }
  }
  // The filter's memory reports motion for some frames after the stop.
  EXPECT_GE(reported_at_rest, 12);
  EXPECT_LE(reported_at_rest, 12 + static_cast<int>(10.0 * motion.memory_s));
  EXPECT_GE(moving, 6) << "from its confirmation to the stop";
  EXPECT_LE(moving, 12 + static_cast<int>(10.0 * motion.memory_s)) << "kept, but no longer said to move";
}

TEST(MotionSegmenter, KeepsTheLargestObjectsAndCountsTheRest) {
  std::vector<test::SyntheticObject> cars(3, {{4.0, 1.5, 1.8}, 50});
  for (const int max_objects : {3, 2}) {
    MotionScene scene(street(), cars, {}, max_objects);
    SceneScore score;
    std::uint64_t dropped_before = 0;
    for (int i = 0; i < 9; ++i) {
      dropped_before = scene.segmenter().counters().detections_dropped;
      score = scene.step(
          {}, std::array{test::turned(0.0, {-6.0 + 0.5 * i, 0.6, 14.0}), test::turned(0.0, {0.0 + 0.5 * i, 0.6, 20.0}),
                         test::turned(0.0, {14.0 + 0.5 * i, 0.6, 30.0})});
    }
    EXPECT_EQ(score.detections, static_cast<std::size_t>(max_objects));
    EXPECT_EQ(score.hits[2], max_objects == 3 ? 1U : 0U) << "the farthest looks smallest";
    EXPECT_EQ(scene.segmenter().counters().detections_dropped - dropped_before, max_objects == 3 ? 0U : 1U);
    const StereoGeometry rig = test::street_rig();
    std::vector<double> depths_m;
    for (std::size_t k = 0; k < scene.last().left.size(); ++k) {
      EXPECT_EQ(scene.last().left[k].label, k + 1);
      depths_m.push_back(rig.fx_px * rig.baseline_m / scene.segmenter().disparities_px()[k]);
    }
    using testing::DoubleNear;
    if (max_objects == 3) {
      EXPECT_THAT(depths_m,
                  testing::UnorderedElementsAre(DoubleNear(14.0, 1.0), DoubleNear(20.0, 1.5), DoubleNear(30.0, 2.5)));
    }
  }
}

TEST(MotionSegmenter, DescribesItsMasks) {
  MotionScene scene(street(), {{{4.0, 1.5, 1.8}, 60}});
  for (int i = 0; i < 8; ++i) {
    scene.step({}, std::array{test::turned(0.0, {-2.0 + 0.6 * i, 0.6, 15.0})});
  }
  ASSERT_EQ(scene.last().left.size(), 1U);
  const Detection& detection = scene.last().left[0];
  PixelBox box;
  int area = 0;
  for (int y = 0; y < scene.last().left_labels.height; ++y) {
    for (int x = 0; x < scene.last().left_labels.width; ++x) {
      if (scene.last().left_labels.at(x, y) == detection.label) {
        box.include(x, y);
        ++area;
      }
    }
  }
  EXPECT_EQ(detection.area_px, area);
  EXPECT_EQ(detection.class_id, kUnknownClass);
  EXPECT_EQ(std::tie(detection.box_px.x0, detection.box_px.y0, detection.box_px.x1, detection.box_px.y1),
            std::tie(box.x0, box.y0, box.x1, box.y1));
  EXPECT_TRUE(scene.last().right_labels.empty());
}

TEST(MotionSegmenter, HasNothingToSayWithoutEgoMotionAndStartsAgain) {
  MotionScene scene(street(), {{{4.0, 1.5, 1.8}, 60}});
  const auto step = [&](int i, bool ego_valid) {
    return scene.step(test::driven(0.5 * i), std::array{test::turned(0.0, {-4.0 + 0.6 * i, 0.6, 25.0})}, ego_valid);
  };
  for (int i = 0; i < 8; ++i) {
    step(i, true);
  }
  EXPECT_EQ(scene.last().left.size(), 1U);
  step(8, false);
  EXPECT_FALSE(scene.last().available);
  EXPECT_EQ(scene.segmenter().counters().frames_missing, 2U);  // and the very first frame
  step(9, true);
  EXPECT_TRUE(scene.last().available);
  EXPECT_TRUE(scene.last().left.empty());
  for (int i = 10; i < 15; ++i) {
    step(i, true);
  }
  EXPECT_EQ(scene.last().left.size(), 1U);
}

TEST(MotionSegmenter, GivesTheSameResultForTheSameInput) {
  std::array<std::vector<std::uint8_t>, 2> images;
  for (std::vector<std::uint8_t>& image : images) {
    MotionScene scene(street(5), {{{4.0, 1.5, 1.8}, 60}});
    for (int i = 0; i < 10; ++i) {
      scene.step(test::driven(0.4 * i), std::array{test::turned(0.0, {-2.0 + 0.6 * i, 0.6, 20.0})});
      const LabelView labels = scene.last().left_labels;
      for (int y = 0; i > 0 && y < labels.height; ++y) {
        image.insert(image.end(), labels.row(y), labels.row(y) + labels.width);
      }
    }
  }
  EXPECT_EQ(images[0], images[1]);
}

TEST(MotionSegmenter, NeedsExactlyTheBytesItAnnounces) {
  SegmentationConfig config;
  config.mode = SegmentationMode::kMotion;
  const std::size_t bytes = required_bytes(config, test::street_rig(), 1000);
  Arena enough(bytes);
  EXPECT_TRUE(make_segmenter(config, test::street_rig(), 1000, enough).has_value());
  EXPECT_EQ(enough.used_bytes(), bytes);
  Arena too_small(bytes - 1);
  EXPECT_EQ(make_segmenter(config, test::street_rig(), 1000, too_small).error().code, ErrorCode::kCapacity);
  EXPECT_EQ(make_segmenter(config, test::street_rig(), 0, enough).error().code, ErrorCode::kInvalidConfig);
}

}  // namespace
}  // namespace kinetrace::segmentation

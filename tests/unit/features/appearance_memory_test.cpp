// Points stored in one frame and recognised in another, at another scale and position.
#include "kinetrace/features/appearance_memory.hpp"

#include <algorithm>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "front_end_harness.hpp"

namespace kinetrace::features {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2f;
using Eigen::Vector3f;
using testing::Harness;
using testing::Scene;
using testing::StereoImage;
using testing::Texture;

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr double kDisparity_px = 14.0;
constexpr double kZoom = 1.4;
constexpr double kFineness = 12.0;
constexpr double kFineContrast = 0.5;
constexpr double kMeanGray = 128.0;
constexpr std::uint8_t kBody = kBackgroundLabel;
const Vector2d kCentre(160.0, 120.0);
const Vector2d kShift(23.0, -11.0);

/// Maps a point of the first view to the second, at another scale and position.
Vector2d moved(const Vector2d& p, double zoom = kZoom) {
  return zoom * (p - kCentre) + kCentre + kShift;
}

/// The second view from nearby, with structure that the first could not resolve.
StereoImage near_view_of(const Texture& texture, double zoom) {
  const Texture fine(53);
  Scene scene;
  scene.width = kWidth;
  scene.height = kHeight;
  scene.noise_gray = 2.0;
  scene.disparity.at_centre = zoom * kDisparity_px;
  scene.left = [&texture, &fine, zoom](const Vector2d& p) {
    const Vector2d q = (p - kShift - kCentre) / zoom + kCentre;
    return texture(q) + kFineContrast * (fine(kFineness * q) - kMeanGray);
  };
  return scene.render(2);
}

StereoImage view_of(const Texture& texture, bool second, unsigned seed) {
  Scene scene;
  scene.width = kWidth;
  scene.height = kHeight;
  scene.noise_gray = 2.0;
  scene.disparity.at_centre = second ? kZoom * kDisparity_px : kDisparity_px;
  scene.left = [&texture, second](const Vector2d& p) {
    return texture(second ? Vector2d((p - kShift - kCentre) / kZoom + kCentre) : p);
  };
  return scene.render(seed);
}

/// Body coordinates are the first view's columns and rows.
std::vector<KnownPoint> known(const std::vector<Feature>& features) {
  std::vector<KnownPoint> points;
  for (const Feature& feature : features) {
    if (feature.has_right()) {
      points.push_back({feature.slot, {feature.left_px.x(), feature.left_px.y(), 0.F}});
    }
  }
  return points;
}

class AppearanceMemoryTest : public ::testing::Test {
 protected:
  /// Stores as many points of the first view as `memory` holds, central ones first; shows a second view.
  void remember_then_see(AppearanceMemory& memory, const StereoImage& second) {
    std::vector<KnownPoint> points = known(harness_.process(view_of(texture_, false, 1)));
    std::sort(points.begin(), points.end(), [](const KnownPoint& a, const KnownPoint& b) {
      return (a.p_body.head<2>().cast<double>() - kCentre).norm() <
             (b.p_body.head<2>().cast<double>() - kCentre).norm();
    });
    harness_->remember(points, memory);
    // Tracks do not survive uniform gray frames.
    harness_.process({testing::Image(kWidth, kHeight, 128), testing::Image(kWidth, kHeight, 128)});
    seen_ = harness_.process(second);
  }

  /// Points recognised around their positions in the second view, predicted with an error of `guess_error`.
  std::vector<RecognisedPoint> recognise(const AppearanceMemory& memory, const Vector2f& guess_error,
                                         const Vector2f& reach_px, std::uint8_t body = kBody, std::size_t room = 400) {
    return recognise(memory, guess_error, RecognitionGate{reach_px}, kZoom, body, room);
  }
  std::vector<RecognisedPoint> recognise(const AppearanceMemory& memory, const Vector2f& guess_error,
                                         const RecognitionGate& gate, double zoom, std::uint8_t body = kBody,
                                         std::size_t room = 400) {
    std::vector<ExpectedObservation> expected;
    for (std::size_t i = 0; i < memory.size(); ++i) {
      expected.emplace_back(moved(memory.p_body(i).head<2>().cast<double>(), zoom).cast<float>() + guess_error);
    }
    std::vector<RecognisedPoint> found(room);
    found.resize(harness_->recognise(memory, expected, gate, body, found));
    return found;
  }

  Texture texture_{51};
  Harness harness_{{}, kWidth, kHeight};
  Arena arena_{std::size_t{1} << 18};
  AppearanceMemory memory_of_zoom_{30, arena_};
  std::vector<Feature> seen_;
};

double error_px(const RecognisedPoint& point, double zoom = kZoom) {
  return (point.left_px.cast<double>() - moved(point.p_body.head<2>().cast<double>(), zoom)).norm();
}

TEST_F(AppearanceMemoryTest, RecognisesPointsThatAreElsewhereAndLarger) {
  AppearanceMemory memory(30, arena_);
  remember_then_see(memory, view_of(texture_, true, 2));
  ASSERT_EQ(memory.size(), 30U);
  std::set<float> right_ones;
  std::vector<double> errors_px;
  std::size_t wrong = 0;
  for (const RecognisedPoint& point : recognise(memory, {9.F, -6.F}, {25.F, 15.F})) {
    if (error_px(point) > 1.5) {
      ++wrong;
      continue;
    }
    right_ones.insert(point.p_body.x());
    errors_px.push_back(error_px(point));
    EXPECT_EQ(memory.p_body(point.point), point.p_body);
    EXPECT_NEAR(point.left_px.x() - point.u_right_px, kZoom * kDisparity_px, 0.5);
    EXPECT_NEAR(point.v_px, point.left_px.y(), 0.5F);
  }
  EXPECT_GE(right_ones.size(), 15U);
  EXPECT_LT(testing::median(errors_px), 0.3);
  EXPECT_LT(wrong, errors_px.size()) << "what looks alike by chance";
}

TEST_F(AppearanceMemoryTest, RecognisesFromNearbyWhatItSawCoarsely) {
  for (const double zoom : {1.6, 2.0, 2.3}) {
    memory_of_zoom_.clear();
    remember_then_see(memory_of_zoom_, near_view_of(texture_, zoom));
    std::set<float> right_ones;
    for (const RecognisedPoint& point : recognise(memory_of_zoom_, {5.F, -3.F}, {{15.F, 15.F}}, zoom)) {
      if (error_px(point, zoom) <= 2.0) {
        right_ones.insert(point.p_body.x());
      }
    }
    EXPECT_GE(right_ones.size(), 8U) << zoom;
  }
}

TEST_F(AppearanceMemoryTest, FindsMoreWhereLessSimilarityWillDo) {
  AppearanceMemory memory(30, arena_);
  remember_then_see(memory, near_view_of(texture_, 2.0));
  const auto found = [&](float least) { return recognise(memory, {0.F, 0.F}, {{10.F, 10.F}, least}, 2.0).size(); };
  EXPECT_GT(found(0.6F), found(0.95F));
  EXPECT_EQ(found(1.01F), 0U);
}

TEST_F(AppearanceMemoryTest, RecognisesLittleInSomethingElse) {
  const Texture other(52);
  AppearanceMemory memory(30, arena_);
  remember_then_see(memory, view_of(other, true, 2));
  EXPECT_GT(seen_.size(), 50U);
  EXPECT_LE(recognise(memory, {0.F, 0.F}, {25.F, 15.F}).size(), 4U);
}

TEST_F(AppearanceMemoryTest, LooksNoFurtherThanItsReachAndAtOneBodyOnly) {
  AppearanceMemory memory(30, arena_);
  remember_then_see(memory, view_of(texture_, true, 2));
  const auto in_place = [](const std::vector<RecognisedPoint>& found) {
    return std::count_if(found.begin(), found.end(), [](const RecognisedPoint& p) { return error_px(p) <= 1.5; });
  };
  EXPECT_GT(in_place(recognise(memory, {12.F, 0.F}, {20.F, 8.F})), 10);
  EXPECT_EQ(in_place(recognise(memory, {30.F, 0.F}, {20.F, 8.F})), 0) << "columns";
  EXPECT_GT(in_place(recognise(memory, {0.F, 12.F}, {8.F, 20.F})), 10);
  EXPECT_EQ(in_place(recognise(memory, {0.F, 30.F}, {8.F, 20.F})), 0) << "rows";
  EXPECT_TRUE(recognise(memory, {0.F, 0.F}, {20.F, 8.F}, kBody + 1).empty());
}

TEST_F(AppearanceMemoryTest, WritesNoMoreThanThereIsRoomFor) {
  AppearanceMemory memory(30, arena_);
  remember_then_see(memory, view_of(texture_, true, 2));
  const std::size_t all = recognise(memory, {0.F, 0.F}, {20.F, 15.F}).size();
  ASSERT_GT(all, 2U);
  for (const std::size_t room : {std::size_t{0}, std::size_t{1}, all - 1, all, all + 1}) {
    EXPECT_EQ(recognise(memory, {0.F, 0.F}, {20.F, 15.F}, kBody, room).size(), std::min(room, all)) << room;
  }
}

TEST_F(AppearanceMemoryTest, HoldsTheFirstOnesUpToItsCapacity) {
  const std::vector<KnownPoint> points = known(harness_.process(view_of(texture_, false, 1)));
  ASSERT_GT(points.size(), 6U);
  AppearanceMemory memory(5, arena_);
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{5}, std::size_t{6}, points.size()}) {
    harness_->remember(std::span(points).first(count), memory);
    ASSERT_EQ(memory.size(), std::min(count, std::size_t{5})) << count;
    for (std::size_t i = 0; i < memory.size(); ++i) {
      EXPECT_EQ(memory.p_body(i), points[i].p_body);
    }
  }
}

TEST_F(AppearanceMemoryTest, LeavesOutWhatIsDeadOrWithoutARightMatch) {
  const std::vector<Feature> features = harness_.process(view_of(texture_, false, 1));
  std::vector<KnownPoint> points;
  std::vector<float> matched;
  for (const Feature& feature : features) {
    points.push_back({feature.slot, Vector3f::Constant(static_cast<float>(feature.id))});
    if (feature.has_right()) {
      matched.push_back(static_cast<float>(feature.id));
    }
  }
  // A slot that was never used.
  points.insert(points.begin(), {static_cast<std::uint16_t>(FeatureConfig{}.max_features - 1), Vector3f::Zero()});
  ASSERT_LT(matched.size(), features.size()) << "near the left border the right image shows nothing";
  AppearanceMemory memory(features.size() + 1, arena_);
  harness_->remember(points, memory);
  std::vector<float> remembered;
  for (std::size_t i = 0; i < memory.size(); ++i) {
    remembered.push_back(memory.p_body(i).x());
  }
  EXPECT_EQ(remembered, matched);
  harness_.process({testing::Image(kWidth, kHeight, 128), testing::Image(kWidth, kHeight, 128)});
  memory.clear();
  harness_->remember(points, memory);
  EXPECT_EQ(memory.size(), 0U) << "all have died";
}

TEST_F(AppearanceMemoryTest, KeepsWhatItHeldAndForgetsWhatWasNotedLongestAgo) {
  const std::vector<KnownPoint> points = known(harness_.process(view_of(texture_, false, 1)));
  ASSERT_GE(points.size(), 7U);
  AppearanceMemory memory(5, arena_);
  const auto note = [&](std::size_t first, std::size_t count) {
    harness_->remember(std::span(points).subspan(first, count), memory);
  };
  const auto held = [&] {
    std::set<std::size_t> indices;
    for (std::size_t i = 0; i < memory.size(); ++i) {
      for (std::size_t k = 0; k < points.size(); ++k) {
        if (points[k].p_body == memory.p_body(i)) {
          indices.insert(k);
        }
      }
    }
    return indices;
  };
  note(0, 3);
  note(1, 4);
  EXPECT_EQ(held(), (std::set<std::size_t>{0, 1, 2, 3, 4})) << "a point noted twice is held once";
  note(5, 1);
  EXPECT_EQ(held(), (std::set<std::size_t>{1, 2, 3, 4, 5}));
  note(4, 3);
  EXPECT_TRUE(held().contains(4) && held().contains(5) && held().contains(6));
  EXPECT_EQ(memory.size(), 5U);
}

TEST_F(AppearanceMemoryTest, EmptyRecognisesNothing) {
  AppearanceMemory memory(30, arena_);
  EXPECT_EQ(memory.size(), 0U);
  harness_.process(view_of(texture_, false, 1));
  EXPECT_TRUE(recognise(memory, {0.F, 0.F}, {100.F, 100.F}).empty());
  AppearanceMemory none;
  EXPECT_TRUE(recognise(none, {0.F, 0.F}, {100.F, 100.F}).empty());
}

TEST_F(AppearanceMemoryTest, IsEmptyOnceClearedAndGoesWhereItIsSwapped) {
  const std::vector<KnownPoint> points = known(harness_.process(view_of(texture_, false, 1)));
  AppearanceMemory full(3, arena_);
  AppearanceMemory empty(7, arena_);
  harness_->remember(points, full);
  full.swap(empty);
  EXPECT_EQ(full.size(), 0U);
  ASSERT_EQ(empty.size(), 3U);
  EXPECT_EQ(empty.p_body(2), points[2].p_body);
  harness_->remember(points, full);
  EXPECT_EQ(full.size(), 7U) << "the capacity goes along";
  full.clear();
  EXPECT_EQ(full.size(), 0U);
}

TEST(AppearanceMemory, TakesNineTenthsOfAKilobyteForEachPoint) {
  const std::size_t bytes = measure_bytes([](Arena& arena) { AppearanceMemory(100, arena); });
  EXPECT_LE(bytes, 100U * 922U);
  EXPECT_GT(bytes, 100U * 820U);
}

}  // namespace
}  // namespace kinetrace::features

// Births, deaths, slots, ids, bodies and capacities.
#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "front_end_harness.hpp"

namespace kinetrace::features {
namespace {

using Eigen::Vector2d;
using testing::by_id;
using testing::Harness;
using testing::Image;
using testing::Scene;
using testing::StereoImage;
using testing::Texture;

constexpr int kWidth = 320;
constexpr int kHeight = 240;

/// One still, textured pair for all tests.
const StereoImage& still() {
  static const StereoImage images = [] {
    const Texture texture(21);
    Scene scene;
    scene.left = [&](const Vector2d& p) { return texture(p); };
    return scene.render();
  }();
  return images;
}

/// Labels with one rectangle of an object.
Image labels_with(std::uint8_t label, int x0, int y0, int x1, int y1) {
  Image labels(kWidth, kHeight, kBackgroundLabel);
  for (int y = y0; y < y1; ++y) {
    std::fill_n(labels.pixels().row(y) + x0, x1 - x0, label);
  }
  return labels;
}

std::size_t count_body(const std::vector<Feature>& features, std::uint8_t body) {
  return static_cast<std::size_t>(
      std::count_if(features.begin(), features.end(), [&](const Feature& f) { return f.body == body; }));
}

/// Ascending.
std::vector<std::uint32_t> ids_of(const std::vector<Feature>& features, std::uint8_t body) {
  std::set<std::uint32_t> ids;
  for (const Feature& feature : features) {
    if (feature.body == body) {
      ids.insert(feature.id);
    }
  }
  return {ids.begin(), ids.end()};
}

TEST(FeatureLifecycle, NewFeaturesHaveIdsAgesAndNoPast) {
  Harness harness({}, kWidth, kHeight);
  std::set<std::uint32_t> ids;
  std::uint16_t last_slot = 0;
  for (const Feature& feature : harness.process(still())) {
    EXPECT_NE(feature.id, 0U);
    EXPECT_TRUE(ids.insert(feature.id).second);
    EXPECT_EQ(feature.age_frames, 0U);
    EXPECT_EQ(feature.previous_left_px, feature.left_px);
    EXPECT_FALSE(feature.had_right());
    EXPECT_EQ(feature.body, kBackgroundLabel);
    EXPECT_TRUE(ids.size() == 1 || feature.slot > last_slot) << "ascending slots";
    last_slot = feature.slot;
  }
  EXPECT_GT(ids.size(), 80U);
  EXPECT_EQ(harness->counters().created, ids.size());
}

TEST(FeatureLifecycle, FeaturesKeepTheirDistance) {
  FeatureConfig config;
  config.min_distance_px = 8;
  config.bucket_px = 8;
  Harness harness(config, kWidth, kHeight);
  const auto features = harness.process(still());
  for (const Feature& a : features) {
    for (const Feature& b : features) {
      if (a.id < b.id) {
        ASSERT_GT((a.left_px - b.left_px).lpNorm<Eigen::Infinity>(), 6.F);
      }
    }
  }
}

TEST(FeatureLifecycle, AStillSceneKeepsItsFeatures) {
  Harness harness({}, kWidth, kHeight);
  const auto first = by_id(harness.process(still()));
  for (int frame = 0; frame < 3; ++frame) {
    const auto now = by_id(harness.process(still()));
    for (const auto& [id, feature] : first) {
      ASSERT_TRUE(now.contains(id));
      EXPECT_LE((now.at(id).left_px - feature.left_px).norm(), 0.02F);
    }
  }
  EXPECT_EQ(harness->counters().lost(), 0U);
}

TEST(FeatureLifecycle, RejectedFeaturesDieAtTheNextTrackAndTheirSlotsComeBackAFrameLater) {
  FeatureConfig config;
  config.max_features = 50;
  config.max_background_features = 50;
  Harness harness(config, kWidth, kHeight);
  const auto born = harness.process(still());
  ASSERT_EQ(born.size(), 50U) << "every slot is in use";
  const std::vector<std::uint16_t> slots{born[3].slot, born[7].slot, 60000};
  harness->reject(slots);
  harness->reject(slots);

  const auto tracked = harness.track(still());
  EXPECT_EQ(tracked.size(), 48U);
  EXPECT_FALSE(by_id(tracked).contains(born[3].id));
  EXPECT_EQ(harness->counters().rejected, 2U);
  EXPECT_EQ(harness.replenish().size(), 48U) << "their slots are not reused in the frame of their death";

  const auto later = harness.process(still());
  EXPECT_EQ(later.size(), 50U);
  for (const Feature& feature : later) {
    if (feature.slot == born[3].slot) {
      EXPECT_GT(feature.id, born.back().id) << "a new feature, a new id";
    }
  }
}

TEST(FeatureLifecycle, NeverExceedsItsCapacityAndCountsWhatItDrops) {
  FeatureConfig config;
  config.bucket_px = 8;
  config.max_features = 1000;
  config.max_background_features = 1000;
  Harness roomy(config, kWidth, kHeight);
  const std::size_t wanted = roomy.process(still()).size();
  EXPECT_EQ(roomy->counters().dropped, 0U);
  ASSERT_GT(wanted, 100U);

  config.max_background_features = static_cast<int>(wanted);
  Harness exact(config, kWidth, kHeight);
  EXPECT_EQ(exact.process(still()).size(), wanted);
  EXPECT_EQ(exact->counters().dropped, 0U);

  config.max_background_features = static_cast<int>(wanted) - 1;
  Harness tight(config, kWidth, kHeight);
  EXPECT_EQ(tight.process(still()).size(), wanted - 1);
  EXPECT_GE(tight->counters().dropped, 1U);
}

TEST(FeatureLifecycle, ObjectsGetFeaturesThoughTheBackgroundWouldTakeThemAll) {
  FeatureConfig config;
  config.max_features = 60;
  config.max_background_features = 40;
  config.max_features_per_object = 15;
  Harness harness(config, kWidth, kHeight);
  EXPECT_EQ(harness.process(still()).size(), 40U);
  const Image labels = labels_with(3, 200, 60, 280, 120);
  harness.process(still(), labels.view());
  const auto features = harness.process(still(), labels.view());
  EXPECT_EQ(count_body(features, 3), 15U) << "its own limit";
  EXPECT_LE(count_body(features, 0), 40U);
}

TEST(FeatureLifecycle, SmallObjectsGetFinerBuckets) {
  Harness harness({}, kWidth, kHeight);
  const Image labels = labels_with(1, 100, 100, 140, 124);
  const auto features = harness.process(still(), labels.view());
  EXPECT_GE(count_body(features, 1), 8U) << "a 24 px bucket would give two";
  for (const Feature& feature : features) {
    if (feature.body == 1) {
      EXPECT_TRUE(feature.left_px.x() >= 99.F && feature.left_px.x() <= 141.F);
      EXPECT_TRUE(feature.left_px.y() >= 99.F && feature.left_px.y() <= 125.F);
    }
  }
}

TEST(FeatureLifecycle, AFeatureWhoseBodyChangesDiesAndANewOneIsBorn) {
  Harness harness({}, kWidth, kHeight);
  const auto born = harness.process(still());
  const Image labels = labels_with(2, 100, 50, 220, 190);
  const auto now = harness.process(still(), labels.view());
  const auto alive = by_id(now);
  for (const Feature& feature : born) {
    const Eigen::Vector2f p = feature.left_px;
    if (p.x() > 104 && p.x() < 215 && p.y() > 54 && p.y() < 185) {
      EXPECT_FALSE(alive.contains(feature.id)) << p.transpose();
    } else if (p.x() < 97 || p.x() > 223 || p.y() < 47 || p.y() > 193) {
      EXPECT_TRUE(alive.contains(feature.id)) << p.transpose();
    }
  }
  EXPECT_GT(harness->counters().lost_body, 10U);
  EXPECT_GT(count_body(now, 2), 10U);
  // No mask at all: everything is background again.
  const auto last = harness.process(still());
  EXPECT_EQ(count_body(last, 2), 0U);
}

TEST(FeatureLifecycle, MasksMayBeTwoPixelsOff) {
  Harness harness({}, kWidth, kHeight);
  const auto born = harness.process(still(), labels_with(2, 100, 50, 220, 190).view());
  harness.track(still());
  // Two pixels wider on each side: background features there keep their label.
  const auto alive = by_id(harness.replenish(labels_with(2, 98, 48, 222, 192).view()));
  for (const Feature& feature : born) {
    EXPECT_TRUE(alive.contains(feature.id)) << feature.left_px.transpose() << " body " << int{feature.body};
    EXPECT_EQ(alive.at(feature.id).body, feature.body);
  }
}

TEST(FeatureLifecycle, NothingLivesUnderTheIgnoreLabel) {
  Harness harness({}, kWidth, kHeight);
  harness.process(still());
  const Image labels = labels_with(kIgnoreLabel, 100, 50, 220, 190);
  for (const Feature& feature : harness.process(still(), labels.view())) {
    const bool inside =
        feature.left_px.x() > 101 && feature.left_px.x() < 219 && feature.left_px.y() > 51 && feature.left_px.y() < 189;
    EXPECT_FALSE(inside) << feature.left_px.transpose();
    EXPECT_NE(feature.body, kIgnoreLabel);
  }
}

TEST(FeatureLifecycle, ResetForgetsFeaturesButNotIds) {
  Harness harness({}, kWidth, kHeight);
  const auto before = harness.process(still());
  harness->reset();
  EXPECT_EQ(harness->counters().created, 0U);
  const auto after = harness.process(still());
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_EQ(after[i].left_px, before[i].left_px);
    EXPECT_GT(after[i].id, before.back().id);
  }
}

TEST(FeatureLifecycle, SameInputGivesTheSameOutputBitForBit) {
  const Texture texture(5);
  std::vector<StereoImage> frames;
  for (unsigned i = 0; i < 4; ++i) {
    Scene scene;
    scene.noise_gray = 2.0;
    scene.left = [&](const Vector2d& p) { return texture(p - Vector2d(3.3, 1.2) * i); };
    frames.push_back(scene.render(i + 1));
  }
  Harness a({}, kWidth, kHeight);
  Harness b({}, kWidth, kHeight);
  for (const StereoImage& frame : frames) {
    const auto from_a = a.process(frame);
    const auto from_b = b.process(frame);
    ASSERT_EQ(from_a.size(), from_b.size());
    for (std::size_t i = 0; i < from_a.size(); ++i) {
      EXPECT_EQ(from_a[i].id, from_b[i].id);
      EXPECT_EQ(from_a[i].left_px, from_b[i].left_px);
      EXPECT_TRUE(from_a[i].u_right_px == from_b[i].u_right_px || !from_a[i].has_right());
      EXPECT_EQ(from_a[i].has_right(), from_b[i].has_right());
    }
  }
}

TEST(FeatureFrontEnd, RefusesCallsOutOfOrder) {
  Harness harness({}, kWidth, kHeight);
  EXPECT_EQ(harness->track({}).error().code, ErrorCode::kIllegalState);
  EXPECT_EQ(harness->replenish({}).error().code, ErrorCode::kIllegalState);
  ASSERT_TRUE(harness->begin_frame(still().pair()));
  EXPECT_EQ(harness->replenish({}).error().code, ErrorCode::kIllegalState);
  EXPECT_TRUE(harness->track({}));
  EXPECT_EQ(harness->track({}).error().code, ErrorCode::kIllegalState);
  EXPECT_TRUE(harness->replenish({}));
}

TEST(FeatureFrontEnd, RefusesImagesAndLabelsOfAnotherSize) {
  Harness harness({}, kWidth, kHeight);
  RectifiedPair pair = still().pair(17);
  pair.right.width -= 1;
  const Status status = harness->begin_frame(pair);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(status.error().message, "features: frame 17 measures 319 x 240 pixels, expected 320 x 240");
  pair.right = {};
  EXPECT_FALSE(harness->begin_frame(pair));

  harness.track(still());
  EXPECT_EQ(harness->replenish(Image(kWidth, kHeight - 1).view()).error().code, ErrorCode::kInvalidArgument);
}

TEST(FeatureFrontEnd, CreateNamesWhatIsWrong) {
  Arena arena(std::size_t{1} << 20);
  FeatureConfig bad;
  bad.bucket_px = 0;
  EXPECT_EQ(FeatureFrontEnd::create(bad, kWidth, kHeight, arena).error().code, ErrorCode::kInvalidConfig);
  EXPECT_EQ(FeatureFrontEnd::create({}, 63, 48, arena).error().code, ErrorCode::kInvalidArgument);
}

TEST(FeatureFrontEnd, NeedsExactlyTheBytesItAsksFor) {
  const std::size_t bytes = FeatureFrontEnd::required_bytes({}, kWidth, kHeight);
  Arena enough(bytes);
  EXPECT_TRUE(FeatureFrontEnd::create({}, kWidth, kHeight, enough));
  EXPECT_EQ(enough.used_bytes(), bytes);
  Arena short_of_one(bytes - 1);
  const auto refused = FeatureFrontEnd::create({}, kWidth, kHeight, short_of_one);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kCapacity);
}

TEST(FeatureFrontEnd, TakesTheSmallestImage) {
  const Texture texture(5);
  Scene scene;
  scene.width = 64;
  scene.height = 48;
  scene.disparity.at_centre = 4.0;
  scene.left = [&](const Vector2d& p) { return texture(p); };
  FeatureConfig config;
  config.bucket_px = 8;
  Harness harness(config, 64, 48);
  EXPECT_FALSE(harness.process(scene.render(1)).empty());
  EXPECT_FALSE(harness.track(scene.render(2)).empty());
}

}  // namespace
TEST(FeatureLifecycle, ALimitEndsTheYoungestOfEachBodyAndGoesAgain) {
  FeatureConfig config;
  config.max_background_features = 60;
  config.max_features_per_object = 20;
  Harness harness(config, kWidth, kHeight);
  const Image labels = labels_with(7, 100, 60, 220, 180);
  const std::vector<Feature> all = harness.process(still(), labels.view());
  ASSERT_EQ(count_body(all, kBackgroundLabel), 60U);
  ASSERT_EQ(count_body(all, 7), 20U);

  harness->limit(0.5);
  const std::vector<Feature> some = harness.process(still(), labels.view());
  EXPECT_EQ(count_body(some, kBackgroundLabel), 30U);
  EXPECT_EQ(count_body(some, 7), 10U);
  // Ids grow with time: the oldest features stay, except one or two lost in this frame anyway.
  EXPECT_GE(harness->counters().lost_limit, 38U);
  for (const std::uint8_t body : {kBackgroundLabel, std::uint8_t{7}}) {
    const std::vector<std::uint32_t> before = ids_of(all, body);
    const std::vector<std::uint32_t> after = ids_of(some, body);
    EXPECT_LE(after.back(), before[after.size() + 1]) << int{body};
  }

  harness->limit(1.0);
  harness.process(still(), labels.view());  // Slots that ended are free from the next frame on.
  EXPECT_EQ(count_body(harness.process(still(), labels.view()), kBackgroundLabel), 60U);
}

}  // namespace kinetrace::features

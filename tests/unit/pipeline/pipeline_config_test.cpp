// Every setting has one name, and a bad value is refused by that name.
#include <limits>
#include <set>
#include <string>
#include <type_traits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/pipeline/config.hpp"

namespace kinetrace::pipeline {
namespace {

using ::testing::HasSubstr;

template <typename T>
inline constexpr bool kIsNumber = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;

/// Sets setting number `wanted` to an invalid value; remembers its key.
struct Spoil {
  int wanted = 0;
  int count = 0;
  std::string spoiled;

  template <typename T>
  void operator()(std::string_view key, T& field, std::string_view /*description*/) {
    if constexpr (kIsNumber<T>) {
      if (count++ == wanted) {
        field = std::is_integral_v<T> ? T(-1'000'000) : std::numeric_limits<T>::quiet_NaN();
        spoiled = key;
      }
    }
  }
};

TEST(PipelineConfig, DefaultsAreValid) {
  EXPECT_TRUE(PipelineConfig{}.validate());
}

TEST(PipelineConfig, KeysAreDottedAndUniqueAndDescribed) {
  PipelineConfig config;
  std::set<std::string> keys;
  visit_fields(config, [&](std::string_view key, const auto&, std::string_view description) {
    EXPECT_NE(key.find('.'), std::string_view::npos) << key;
    EXPECT_FALSE(description.empty()) << key;
    EXPECT_TRUE(keys.insert(std::string(key)).second) << key << " twice";
  });
  EXPECT_GT(keys.size(), 60U);
}

TEST(PipelineConfig, EveryNumberOutOfRangeIsRefusedByName) {
  int checked = 0;
  for (;; ++checked) {
    PipelineConfig config;
    Spoil spoil{.wanted = checked, .count = 0, .spoiled = {}};
    visit_fields(config, spoil);
    if (spoil.spoiled.empty()) {
      break;
    }
    const Status status = config.validate();
    ASSERT_FALSE(status) << spoil.spoiled;
    EXPECT_EQ(status.error().code, ErrorCode::kInvalidConfig);
    EXPECT_THAT(status.error().message, HasSubstr(spoil.spoiled));
  }
  EXPECT_GT(checked, 60);
}

TEST(PipelineConfig, AnObjectsWindowMayBeShorterThanTheBackgrounds) {
  PipelineConfig config;
  config.object.window_frames = config.background.window_frames + 1;
  const Status status = config.validate();
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, HasSubstr("object.window_frames"));
  config.background.window_frames = config.object.window_frames;
  EXPECT_TRUE(config.validate());
  config.object.window_frames = 1;
  EXPECT_TRUE(config.validate());
  config.background.window_frames = 2;
  EXPECT_THAT(config.validate().error().message, HasSubstr("background.window_frames must be in [3, 32]"));
}

TEST(PipelineConfig, MasksNeedAFolder) {
  PipelineConfig config;
  config.segmentation.mode = segmentation::SegmentationMode::kMasks;
  const Status status = config.validate();
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, HasSubstr("segmentation.left_dir"));
}

}  // namespace
}  // namespace kinetrace::pipeline

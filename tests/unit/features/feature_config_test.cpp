#include "kinetrace/features/feature_config.hpp"

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::features {
namespace {

TEST(FeatureConfig, DefaultsAreValid) {
  EXPECT_TRUE(FeatureConfig{}.validate());
}

TEST(FeatureConfig, NamesTheKeyThatIsOutOfRange) {
  const std::vector<std::pair<std::string, std::function<void(FeatureConfig&)>>> mistakes{
      {"max_features", [](FeatureConfig& c) { c.max_features = 7; }},
      {"max_background_features", [](FeatureConfig& c) { c.max_background_features = 4001; }},
      {"max_features_per_object", [](FeatureConfig& c) { c.max_features_per_object = -1; }},
      {"pyramid_levels", [](FeatureConfig& c) { c.pyramid_levels = 0; }},
      {"bucket_px", [](FeatureConfig& c) { c.bucket_px = 0; }},
      {"object_bucket_px", [](FeatureConfig& c) { c.object_bucket_px = 0; }},
      {"min_distance_px", [](FeatureConfig& c) { c.min_distance_px = 0; }},
      {"min_corner_strength", [](FeatureConfig& c) { c.min_corner_strength = 0.F; }},
      {"min_object_corner_strength", [](FeatureConfig& c) { c.min_object_corner_strength = -1.F; }},
      {"forward_backward_px", [](FeatureConfig& c) { c.forward_backward_px = 0.F; }},
      {"min_correlation", [](FeatureConfig& c) { c.min_correlation = 1.1F; }},
      {"max_residual", [](FeatureConfig& c) { c.max_residual = -1.F; }},
      {"min_patch_strength", [](FeatureConfig& c) { c.min_patch_strength = 0.F; }},
      {"max_disparity_px", [](FeatureConfig& c) { c.max_disparity_px = 257; }},
      {"min_disparity_px", [](FeatureConfig& c) { c.min_disparity_px = std::numeric_limits<float>::quiet_NaN(); }},
      {"max_row_difference_px", [](FeatureConfig& c) { c.max_row_difference_px = 9.F; }},
      {"uniqueness_ratio", [](FeatureConfig& c) { c.uniqueness_ratio = 0.9F; }},
      {"mask_border_px", [](FeatureConfig& c) { c.mask_border_px = -1.F; }},
  };
  for (const auto& [key, make] : mistakes) {
    FeatureConfig config;
    make(config);
    const Status status = config.validate();
    ASSERT_FALSE(status) << key;
    EXPECT_EQ(status.error().code, ErrorCode::kInvalidConfig);
    EXPECT_NE(status.error().message.find("features." + key + " must be in ["), std::string::npos)
        << status.error().message;
  }
}

TEST(FeatureConfig, MessageHoldsRangeAndValue) {
  FeatureConfig config;
  config.max_features = 7;
  EXPECT_EQ(config.validate().error().message, "features.max_features must be in [50, 4000], got 7");
}

}  // namespace
}  // namespace kinetrace::features

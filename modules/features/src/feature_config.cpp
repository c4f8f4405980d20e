#include "kinetrace/features/feature_config.hpp"

#include <sstream>
#include <string>
#include <string_view>

namespace kinetrace::features {
namespace {

/// Checks ranges in turn and keeps the first failure.
class RangeCheck {
 public:
  /// Written so that NaN is out of range.
  template <typename T>
  RangeCheck& within(std::string_view key, T value, T low, T high) {
    if (status_ && !(value >= low && value <= high)) {
      std::ostringstream message;
      message << "features." << key << " must be in [" << low << ", " << high << "], got " << value;
      status_ = fail(ErrorCode::kInvalidConfig, message.str());
    }
    return *this;
  }
  [[nodiscard]] Status status() const { return status_; }

 private:
  Status status_;
};

constexpr int kMaxFeatures = 4000;
// Below any gradient of 8-bit pixels.
constexpr float kMinStrength = 0.1F;
constexpr float kMaxStrength = 128.F;

}  // namespace

Status FeatureConfig::validate() const {
  RangeCheck check;
  check.within("max_features", max_features, 50, kMaxFeatures)
      .within("max_background_features", max_background_features, 0, kMaxFeatures)
      .within("max_features_per_object", max_features_per_object, 0, kMaxFeatures)
      .within("pyramid_levels", pyramid_levels, 1, 6)
      .within("bucket_px", bucket_px, 8, 256)
      .within("object_bucket_px", object_bucket_px, 4, 64)
      .within("min_distance_px", min_distance_px, 4, 64)
      .within("min_corner_strength", min_corner_strength, kMinStrength, kMaxStrength)
      .within("min_object_corner_strength", min_object_corner_strength, kMinStrength, kMaxStrength)
      .within("forward_backward_px", forward_backward_px, 0.01F, 10.F)
      .within("min_correlation", min_correlation, 0.1F, 1.F)
      .within("max_residual", max_residual, 0.F, 255.F)
      .within("min_patch_strength", min_patch_strength, kMinStrength, kMaxStrength)
      .within("max_disparity_px", max_disparity_px, 16, 256)
      .within("min_disparity_px", min_disparity_px, 0.01F, 16.F)
      .within("max_row_difference_px", max_row_difference_px, 0.F, 8.F)
      .within("uniqueness_ratio", uniqueness_ratio, 1.F, 10.F)
      .within("mask_border_px", mask_border_px, 0.F, 16.F);
  return check.status();
}

}  // namespace kinetrace::features

#include "kinetrace/neural/model.hpp"

#include <algorithm>
#include <cmath>

#include "kinetrace/core/config_check.hpp"

namespace kinetrace::neural {
namespace {

constexpr int kStride = 32;  // Of the coarsest level.
constexpr int kMaxSide = 4096;
constexpr int kMaxPixels = kMaxSide * kMaxSide;

int rounded_up(int size) noexcept {
  return (size + kStride - 1) / kStride * kStride;
}

Status check_input(const ModelConfig& model) {
  const ModelInput& input = model.input;
  Status in_range = first_failure({
      check_range("input.width", input.width_px, kStride, kMaxSide),
      check_range("input.height", input.height_px, kStride, kMaxSide),
      check_range("input.pixels", input.max_pixels, 0, kMaxPixels),
      check_range("input.pad", input.pad, 0, 255),
      check_range("input.scale", input.scale, 1e-6F, 1e6F),
  });
  if (!in_range) {
    return in_range;
  }
  if (input.disparity && model.family != ModelFamily::kKinetraceSeg) {
    return fail(ErrorCode::kInvalidConfig, "input.disparity is for models of the family kinetrace-seg; leave it out");
  }
  for (const float deviation : input.deviation) {
    if (!(deviation > 0.F)) {
      return fail(ErrorCode::kInvalidConfig, "input.std must be above 0");
    }
  }
  if (model.family != ModelFamily::kMaskRcnn && (input.width_px % kStride != 0 || input.height_px % kStride != 0)) {
    return fail(ErrorCode::kInvalidConfig, "input.width and input.height must be multiples of 32, not " +
                                               std::to_string(input.width_px) + " and " +
                                               std::to_string(input.height_px));
  }
  if (input.max_pixels != 0 && (model.family != ModelFamily::kKinetraceSeg || input.max_pixels < kStride * kStride)) {
    return fail(ErrorCode::kInvalidConfig,
                model.family == ModelFamily::kKinetraceSeg
                    ? "input.pixels must be at least 1024, or 0 for a given width and height"
                    : "input.pixels is for models of the family kinetrace-seg; give input.width and input.height");
  }
  return {};
}

float log_odds(float probability) noexcept {
  constexpr float kMinProbability = 1e-6F;
  const float p = std::clamp(probability, kMinProbability, 1.F - kMinProbability);
  return std::log(p / (1.F - p));
}

float sigmoid(float log_odds) noexcept {
  return 1.F / (1.F + std::exp(-log_odds));
}

}  // namespace

ModelInput ModelInput::sized_for(int picture_width_px, int picture_height_px) const noexcept {
  ModelInput sized = *this;
  if (max_pixels == 0) {
    return sized;
  }
  const int width = std::max(picture_width_px, 1);
  const int height = std::max(picture_height_px, 1);
  const auto height_at = [&](int input_width) {
    return rounded_up(static_cast<int>((std::int64_t{height} * input_width + width - 1) / width));
  };
  sized.width_px = std::min(rounded_up(width), kMaxSide);
  while (sized.width_px > kStride && std::int64_t{sized.width_px} * height_at(sized.width_px) > max_pixels) {
    sized.width_px -= kStride;
  }
  const int most = std::clamp(max_pixels / sized.width_px / kStride * kStride, kStride, kMaxSide);
  sized.height_px = std::min(height_at(sized.width_px), most);
  sized.max_pixels = 0;
  return sized;
}

float ScoreCalibration::probability(float score) const noexcept {
  return sigmoid(slope * (log_odds(score) - log_odds(even)));
}

float ScoreCalibration::score(float probability) const noexcept {
  return sigmoid(log_odds(probability) / slope + log_odds(even));
}

Status ModelConfig::validate() const {
  if (file.empty()) {
    return fail(ErrorCode::kInvalidConfig, "model must name the network's file");
  }
  if (classes.empty()) {
    return fail(ErrorCode::kInvalidConfig, "classes must name the network's classes, in its order");
  }
  for (const ModelClass& one : classes) {
    Status valid = first_failure({
        check_range(one.name + ": thresholds.score", one.min_score, 0.F, 1.F),
        check_range(one.name + ": calibration.slope", one.calibration.slope, 0.01F, 100.F),
        check_range(one.name + ": calibration.even", one.calibration.even, 0.001F, 0.999F),
    });
    if (!valid) {
      return valid;
    }
  }
  return first_failure({check_input(*this), check_range("thresholds.overlap", thresholds.overlap, 0.F, 1.F)});
}

}  // namespace kinetrace::neural

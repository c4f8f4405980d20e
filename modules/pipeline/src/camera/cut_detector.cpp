#include "camera/cut_detector.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr std::size_t kMinFeatures = 50;  // Fewer may all be lost at once.
// Of a frame's features, the next frame keeps more than half; across a cut, at most a tenth.
constexpr std::size_t kMaxFeaturesPerTracked = 5;
constexpr std::size_t kMaxFeaturesPerCorner = 4;  // One corner for this many features of the previous frame.
constexpr std::int64_t kMaxStepPercent = 150;     // Of the previous step; with longer ones, frames are missing.

}  // namespace

bool CutDetector::is_cut(const FeatureFrame& tracked, std::size_t previous_features,
                         features::FeatureFrontEnd& front_end) noexcept {
  const std::optional<std::int64_t> last_step_ns = last_step_ns_;
  if (last_timestamp_ns_) {
    last_step_ns_ = tracked.timestamp_ns - *last_timestamp_ns_;
  }
  last_timestamp_ns_ = tracked.timestamp_ns;
  const bool is_next = last_step_ns && *last_step_ns_ / kMaxStepPercent <= *last_step_ns / 100;
  const bool is_gap = !is_next && last_step_ns_.value_or(0) > max_gap_ns_;
  return is_gap || (is_next && previous_features >= kMinFeatures &&
                    tracked.features.size() * kMaxFeaturesPerTracked < previous_features &&
                    front_end.count_corners() * kMaxFeaturesPerCorner >= previous_features);
}

}  // namespace kinetrace::pipeline

#include "camera/jump_watch.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr std::size_t kMinFeatures = 50;  // Fewer may all be lost at once.
// Of a frame's features, the next frame keeps more than half; across a cut, at most a tenth.
constexpr std::size_t kFoundAgainOneOf = 5;
constexpr std::size_t kAsMuchToSee = 4;     // One corner for this many features of the previous frame.
constexpr std::int64_t kStepPercent = 150;  // Of the previous step; with longer ones, frames are missing.

}  // namespace

bool JumpWatch::has_jumped(const FeatureFrame& tracked, std::size_t before,
                           features::FeatureFrontEnd& front_end) noexcept {
  const std::optional<std::int64_t> last_step_ns = last_step_ns_;
  if (last_timestamp_ns_) {
    last_step_ns_ = tracked.timestamp_ns - *last_timestamp_ns_;
  }
  last_timestamp_ns_ = tracked.timestamp_ns;
  const bool is_next = last_step_ns && *last_step_ns_ / kStepPercent <= *last_step_ns / 100;
  const bool is_gap = !is_next && last_step_ns_.value_or(0) > max_gap_ns_;
  return is_gap || (is_next && before >= kMinFeatures && tracked.features.size() * kFoundAgainOneOf < before &&
                    front_end.count_corners() * kAsMuchToSee >= before);
}

}  // namespace kinetrace::pipeline

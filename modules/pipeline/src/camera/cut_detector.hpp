// Detection of cuts in a recording.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "kinetrace/core/dwell_time.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/features/feature_front_end.hpp"

namespace kinetrace::pipeline {

/// Detects a recording that restarts or has been cut: hardly any feature of the previous frame is found again, although
/// by the timestamps no frame is missing and the image has enough corners. Over a few missing frames motion is
/// predicted, over a longer gap it is not. A moment of darkness is no cut.
class CutDetector {
 public:
  /// `max_gap_s`: longest gap over which motion is predicted.
  explicit CutDetector(double max_gap_s) : max_gap_ns_(to_ns(max_gap_s)) {}

  /// Call for each frame, after FeatureFrontEnd::track and before replenish. `previous_features`: their number in the
  /// previous frame.
  [[nodiscard]] bool is_cut(const FeatureFrame& tracked, std::size_t previous_features,
                            features::FeatureFrontEnd& front_end) noexcept;

 private:
  std::int64_t max_gap_ns_;
  std::optional<std::int64_t> last_timestamp_ns_;
  std::optional<std::int64_t> last_step_ns_;
};

}  // namespace kinetrace::pipeline

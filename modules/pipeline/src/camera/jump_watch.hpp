// Detection of cuts in a recording.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/features/feature_front_end.hpp"

namespace kinetrace::pipeline {

/// Detects a recording that restarts or has been cut: hardly any feature of the previous frame is found again, although
/// by the timestamps no frame is missing and the image has enough corners. Missing frames and moments of darkness are
/// no cut: the scene goes on.
class JumpWatch {
 public:
  /// Call for each frame, after FeatureFrontEnd::track and before replenish. `before`: number of features of the
  /// previous frame.
  [[nodiscard]] bool has_jumped(const FeatureFrame& tracked, std::size_t before,
                                features::FeatureFrontEnd& front_end) noexcept;

 private:
  std::optional<std::int64_t> last_timestamp_ns_;
  std::optional<std::int64_t> last_step_ns_;
};

}  // namespace kinetrace::pipeline

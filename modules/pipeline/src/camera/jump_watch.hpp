// Whether a frame shows something else than the one before it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "kinetrace/core/dwell_time.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/features/feature_front_end.hpp"

namespace kinetrace::pipeline {

/// Notices a recording that is played once more, or has been cut: next to nothing of the frame before is found again,
/// though the clock shows no missing frame and there is as much to see. Where a few frames are missing, motion goes on;
/// after a longer gap nothing of it can be predicted. A moment of darkness is no jump.
class JumpWatch {
 public:
  /// `max_gap_s`: for which motion is predicted while frames are missing.
  explicit JumpWatch(double max_gap_s) : max_gap_ns_(to_ns(max_gap_s)) {}

  /// Of each frame, after FeatureFrontEnd::track and before replenish. `before`: features of the frame before.
  [[nodiscard]] bool has_jumped(const FeatureFrame& tracked, std::size_t before,
                                features::FeatureFrontEnd& front_end) noexcept;

 private:
  std::int64_t max_gap_ns_;
  std::optional<std::int64_t> last_timestamp_ns_;
  std::optional<std::int64_t> last_step_ns_;
};

}  // namespace kinetrace::pipeline

// Whether a frame shows something else than the one before it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/features/feature_front_end.hpp"

namespace kinetrace::pipeline {

/// Notices a recording that is played once more, or has been cut: next to nothing of the frame before is found again,
/// though the clock says that none is missing and there is as much to see. Where frames are missing, things have moved
/// as the clock tells; where it is dark for a moment, nothing has become of them.
class JumpWatch {
 public:
  /// Of each frame, after FeatureFrontEnd::track and before replenish. `before`: features of the frame before.
  [[nodiscard]] bool has_jumped(const FeatureFrame& tracked, std::size_t before,
                                features::FeatureFrontEnd& front_end) noexcept;

 private:
  std::optional<std::int64_t> last_timestamp_ns_;
  std::optional<std::int64_t> last_step_ns_;
};

}  // namespace kinetrace::pipeline

// When what was expected of a track says something about what is seen.
#pragma once

#include <algorithm>

#include "kinetrace/tracking/track_instance.hpp"

namespace kinetrace::tracking {

/// Nearer things have no size in the image that a similarity could carry.
inline constexpr double kMinPredictionDepth_m = 0.2;

/// A mask of which less than this is in the image is not replaced by what is left of it, as long as it is still found
/// where it is expected.
inline constexpr double kWholeInImage = 0.99;

/// Less than this part of a mask in view is not enough to be detected.
inline constexpr double kMinVisiblePart = 0.3;

/// Of a track that shows so much of its predicted mask, nothing is hidden.
inline constexpr double kWhollyInView = 0.9;

inline bool wholly_in_view(const TrackInstance& instance) noexcept {
  return instance.overlap.area_px >= kWhollyInView * instance.predicted_px;
}

/// What nothing measures grows or shrinks by no more than this from frame to frame.
inline constexpr double kMaxGrowth = 1.25;

/// A disparity by so much greater is that of another thing in front.
inline bool clearly_nearer(float disparity_px, float than_px) noexcept {
  return disparity_px > than_px + std::max(2.F, 0.15F * than_px);
}

}  // namespace kinetrace::tracking

// Thresholds for comparing predictions of a track with observations.
#pragma once

#include <algorithm>

#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/tracking/track_instance.hpp"

namespace kinetrace::tracking {

/// Below this depth the image size of an object is no longer modelled by a similarity.
inline constexpr double kMinPredictionDepth_m = 0.2;

/// A mask with less than this part in the image is not replaced by its visible rest, as long as the detection fits the
/// prediction.
inline constexpr double kMinFractionInImage = 0.99;

/// Below this visible part of a mask no detection is expected.
inline constexpr double kMinVisiblePart = 0.3;

/// From this visible part of its predicted mask on, a track counts as unoccluded.
inline constexpr double kMinUnoccludedFraction = 0.9;

inline bool is_unoccluded(const TrackInstance& instance) noexcept {
  return instance.overlap.area_px >= kMinUnoccludedFraction * instance.predicted_px;
}

/// Maximum change of scale from frame to frame where features do not measure it.
inline constexpr double kMaxGrowth = 1.25;

/// A disparity greater by this margin is that of another object in front.
inline bool is_significantly_nearer(float disparity_px, float than_px) noexcept {
  return disparity_px > than_px + std::max(2.F, 0.15F * than_px);
}

/// A feature on the object's mask that lies nearer than the object, whose disparity is known to three standard
/// deviations: it is an occluder's.
inline bool lies_in_front(const Feature& feature, const ObjectPrediction& object) noexcept {
  return feature.has_right() && object.disparity_px > 0.0 &&
         is_significantly_nearer(feature.disparity_px(),
                                 static_cast<float>(object.disparity_px + 3.0 * object.disparity_sigma_px));
}

}  // namespace kinetrace::tracking

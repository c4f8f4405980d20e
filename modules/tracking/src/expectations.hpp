// When what was expected of a track says something about what is seen.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "kinetrace/tracking/track_instance.hpp"

namespace kinetrace::tracking {

/// Features of a track that has not been detected for longer lie on what hides it, or on nothing.
inline constexpr std::int64_t kForeignAfter_ns = 100'000'000;

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

/// Of the middle of what is seen of an object.
struct UncertainDisparity {
  double mean_px = 0.0;  ///< 0: not known.
  double sigma_px = 0.0;
};

/// Of one feature; features of one object err alike from a few on.
inline constexpr double kFeatureDisparity_px = 0.5;

/// The median of so many features.
inline UncertainDisparity measured_disparity(double mean_px, std::size_t features) noexcept {
  constexpr std::size_t kMaxIndependent = 4;
  const std::size_t independent = std::clamp<std::size_t>(features, 1, kMaxIndependent);
  return {mean_px, kFeatureDisparity_px / std::sqrt(static_cast<double>(independent))};
}

/// Of any feature of a track in this frame: predicted, or as it was last seen.
inline UncertainDisparity expected_disparity(const TrackInstance& instance) noexcept {
  // How far the features of an object lie in front of and behind its middle, in metres or as a part of its distance.
  constexpr double kExtent_m = 1.2;
  constexpr double kExtent = 0.06;
  const ObjectPrediction& prediction = instance.prediction;
  const bool predicted = prediction.disparity_px > 0.0;
  const double seen_px = instance.disparity.known ? double{instance.disparity.mean_px} : 0.0;
  const double mean_px = predicted ? prediction.disparity_px : seen_px;
  const double extent = predicted ? kExtent_m / prediction.depth_m : kExtent;
  return {mean_px, std::hypot(predicted ? prediction.disparity_sigma_px : kFeatureDisparity_px, extent * mean_px)};
}

/// So many standard deviations tell two disparities apart.
inline constexpr double kDistinctSigmas = 3.0;

/// Another thing in front.
inline bool clearly_nearer(const UncertainDisparity& front, const UncertainDisparity& behind) noexcept {
  return front.mean_px > 0.0 && behind.mean_px > 0.0 &&
         front.mean_px - behind.mean_px > kDistinctSigmas * std::hypot(front.sigma_px, behind.sigma_px);
}

}  // namespace kinetrace::tracking

// Terms of the log-likelihood ratio of a known object against a new one, given a detection (Bar-Shalom, Li 1995, ch. 6;
// Blackman, Popoli 1999, sec. 6.2), all in nats.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/image_view.hpp"
#include "kinetrace/tracking/disparity_plane.hpp"
#include "kinetrace/tracking/prediction.hpp"

namespace kinetrace::tracking {

/// Predicted extent of an object's mask, occluded and truncated parts included.
struct BoxPrediction {
  Eigen::Vector2d low_px = Eigen::Vector2d::Zero();  ///< Edges as PixelBox has them; may lie outside the image.
  Eigen::Vector2d high_px = Eigen::Vector2d::Zero();
  /// Of each side alone; 0: relative to the extent, as of a mask.
  Eigen::Vector2d low_sigma_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d high_sigma_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d position_sigma_px = Eigen::Vector2d::Zero();  ///< Of the whole box, along each axis.
  double size_sigma = 0.0;                                      ///< Of its size, relative, common to both axes.
  double occluded = 0.0;                                        ///< Part of it that is expected to be occluded.
  /// Sides that the image border had cut off: the object reaches at least so far.
  std::array<bool, 2> low_is_cut{};
  std::array<bool, 2> high_is_cut{};
};

/// Evidence of the edges of a detection: the predicted object against a new one anywhere in the image, of any size. An
/// edge at the image border only shows that the object reaches it, an occluded one only that the visible part lies
/// within (extended objects: Granstroem, Baum, Reuter 2017).
[[nodiscard]] double box_evidence(const BoxPrediction& predicted, const PixelBox& detected, int width_px,
                                  int height_px);

/// `on_detection` of the object's `total` features tracked into this frame lie on the detection. Errors of the features
/// of one object are correlated, so that many count as a few.
[[nodiscard]] double feature_evidence(double on_detection, int total);

/// Disparity of the object, not known if not positive, with the standard deviation of its prediction, and of the
/// detection, the median over `features`. The fewer there are, the more likely all are outliers.
[[nodiscard]] double disparity_evidence(double object_px, double object_sigma_px, double detection_px,
                                        std::size_t features);

/// Evidence of `samples`, the detection's features, in the object's space: a part of it, wherever its edges are seen.
[[nodiscard]] double volume_evidence(const PredictedVolume& volume, std::span<const DisparitySample> samples);

/// Evidence of a detection in the image being a part of an object with this extent: its centre lies within.
[[nodiscard]] double extent_evidence(const ImageExtent& extent, const PixelBox& detected);

/// Log odds of a detection against a miss, for an object of which the part `visible` can be seen.
[[nodiscard]] double detection_evidence(double visible);

/// Evidence that a detection with this part of it on other objects' masks is a fragment of one; to be subtracted.
[[nodiscard]] double fragment_evidence(double overlap_fraction_with_others);

/// A network, or a vote over several frames, is hardly ever wrong about the class.
inline constexpr double kOtherClassEvidence = -9.0;

}  // namespace kinetrace::tracking

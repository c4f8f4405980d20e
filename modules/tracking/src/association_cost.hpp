// How much more likely a detection shows a known object than a new one: terms of a log-likelihood ratio (Bar-Shalom, Li
// 1995, ch. 6; Blackman, Popoli 1999, sec. 6.2), all in nats.
#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace::tracking {

/// Where the mask of an object is expected, hidden and truncated parts included.
struct BoxPrediction {
  Eigen::Vector2d low_px = Eigen::Vector2d::Zero();  ///< Edges as PixelBox has them; may lie outside the image.
  Eigen::Vector2d high_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d place_sigma_px = Eigen::Vector2d::Zero();  ///< Of the whole box, along each axis.
  double size_sigma = 0.0;                                   ///< Of its size, both axes in common, relative.
  double occluded = 0.0;                                     ///< Part of it that something nearer is expected to hide.
};

/// Log-likelihood of the edges of a detection that shows the predicted object, against those of a new one: anywhere in
/// the image, of any size. An edge at the image's border tells no more than that the object reaches it, a hidden one no
/// more than that what is seen lies within it (extended objects: Granstroem, Baum, Reuter 2017).
[[nodiscard]] double box_evidence(const BoxPrediction& predicted, const PixelBox& seen, int width_px, int height_px);

/// `on_it` of an object's `total` features that have moved on to this frame lie on the detection. Features of one
/// object err together, so that many count as a few.
[[nodiscard]] double feature_evidence(int on_it, int total);

/// Disparities of the object, not known where not positive, with the standard deviation of its prediction, and of the
/// detection, the median over so many features. The fewer they are, the likelier all of them lie on something else.
[[nodiscard]] double disparity_evidence(double object_px, double object_sigma_px, double detection_px,
                                        std::size_t features);

/// For an object of which a part of `visible` can be seen: log of being detected over being missed.
[[nodiscard]] double detection_evidence(double visible);

/// That a detection of which so much lies on other objects' masks is a fragment of those; to be subtracted.
[[nodiscard]] double fragment_evidence(double part_on_others);

/// A network, or a vote of several frames, hardly ever errs in the class.
inline constexpr double kOtherClassEvidence = -9.0;

}  // namespace kinetrace::tracking

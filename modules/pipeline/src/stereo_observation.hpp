// Position measurement of an object by the stereo pair of one frame.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/objects/measurements.hpp"

namespace kinetrace::pipeline {

/// Standard deviation of the disparity of the visible part's centre.
inline constexpr double kObservedDisparitySigma_px = 0.3;

struct StereoObservation {
  int features = 0;                                  ///< With a right match; 0: no observation.
  Eigen::Vector3d uvd_px = Eigen::Vector3d::Zero();  ///< Column, row and disparity of its representative point.
  int agreeing = 0;                                  ///< Features about as far away as that point.
  objects::ImageMotion motion;                       ///< Of its features tracked from the previous frame.
};

/// The medians of the features with this label and at least `min_disparity_px`.
[[nodiscard]] StereoObservation observe_stereo(const FeatureFrame& frame, std::uint8_t label, double min_disparity_px);

/// Camera frame, m.
[[nodiscard]] Eigen::Vector3d position_in_camera(const StereoGeometry& geometry, const StereoObservation& observation);

/// Mean column of the pixels with `label` in `box`; the middle of the box if there are none.
[[nodiscard]] double mean_column(LabelView labels, const PixelBox& box, std::uint8_t label);

}  // namespace kinetrace::pipeline

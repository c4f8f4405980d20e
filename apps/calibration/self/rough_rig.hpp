// Initial rig from pooled left-right pairs alone, good to some pixels: enough to search along rows.
#pragma once

#include <span>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "point_pairs.hpp"
#include "rig_model.hpp"

namespace kinetrace::self_calibration {

struct RoughRig {
  RigModel rig;
  std::vector<PointPair> inliers;  ///< Pairs that fit it.
  double rms_px = 0.0;             ///< Of the inliers' distance from their epipolar lines.
};

/// A rig's epipolar geometry is the same in all frames, so all pairs are pooled: Sampson distances (Hartley and
/// Zisserman, "Multiple View Geometry", 2nd ed., eq. 11.9) with a common radial distortion, minimised with a robust
/// loss of decreasing scale, from parallel views. The focal length is poorly determined by this: `focal_px` stays.
[[nodiscard]] RoughRig rough_rig(std::span<const PointPair> pairs, const ImageSize& size, double baseline_m,
                                 double focal_px);

}  // namespace kinetrace::self_calibration

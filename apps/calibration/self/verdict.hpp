// Whether a recording determines its rig; if not, why, and what to record instead.
#pragma once

#include "kinetrace/core/result.hpp"
#include "scene_evidence.hpp"
#include "uncertainty.hpp"

namespace kinetrace::self_calibration {

/// What the verdict is about.
struct Findings {
  std::size_t windows = 0;
  double used_share = 0.0;  ///< Of the points.
  double sigma_px = 0.0;    ///< Scatter of an observation.
  SceneEvidence scene;
  double focal_sigma = 0.0;  ///< Of ln(fx).
  double depth_sigma = 0.0;  ///< As a part, at fifty baselines.
};

/// Errors: kBadCalibration, with the first that applies of: camera at rest, nothing but rotation, too few points, one
/// plane, a bad fit, a focal length or depths that stay open.
[[nodiscard]] Status verdict(const Findings& findings);

}  // namespace kinetrace::self_calibration

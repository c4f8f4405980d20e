// Whether a recording determines its rig; if not, the reason and what to record.
#pragma once

#include "kinetrace/core/result.hpp"
#include "scene_evidence.hpp"
#include "uncertainty.hpp"

namespace kinetrace::self_calibration {

/// Input of the verdict.
struct Findings {
  std::size_t windows = 0;
  double used_share = 0.0;  ///< Of the points.
  double sigma_px = 0.0;    ///< Scatter of an observation.
  SceneEvidence scene;
  double focal_sigma = 0.0;  ///< Of ln(fx).
  double depth_sigma = 0.0;  ///< Relative, at fifty baselines.
};

/// Errors: kBadCalibration, with the first that applies of: camera at rest, pure rotation, too few points, one plane, a
/// bad fit, undetermined focal length or depths.
[[nodiscard]] Status verdict(const Findings& findings);

}  // namespace kinetrace::self_calibration

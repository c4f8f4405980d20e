// Evidence of a recording for calibration: motion, parallax, depth.
#pragma once

#include <vector>

#include "rig_bundle.hpp"

namespace kinetrace::self_calibration {

struct SceneEvidence {
  std::size_t points = 0;
  double travel_px = 0.0;    ///< Median over tracks of the image motion along a track.
  double parallax_px = 0.0;  ///< Median over tracks of the motion caused by the camera's translation.
  double depth_ratio = 1.0;  ///< Far depth over near depth: ninth decile over first.
  double plane_share = 0.0;  ///< Fraction of the points on one plane, mean over windows.
};

[[nodiscard]] SceneEvidence scene_evidence(const RigModel& rig, const std::vector<BundleWindow>& windows);

}  // namespace kinetrace::self_calibration

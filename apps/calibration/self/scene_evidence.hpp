// What the recording shows that a calibration can be found from: motion, parallax, depth.
#pragma once

#include <vector>

#include "rig_bundle.hpp"

namespace kinetrace::self_calibration {

struct SceneEvidence {
  std::size_t points = 0;
  double travel_px = 0.0;    ///< Median over tracks of how far the image moved over a track.
  double parallax_px = 0.0;  ///< Median over tracks of the part that the camera's translation made.
  double depth_ratio = 1.0;  ///< Far depth over near depth: ninth decile over first.
  double plane_share = 0.0;  ///< Part of the points that lie on one plane, mean over windows.
};

[[nodiscard]] SceneEvidence scene_evidence(const RigModel& rig, const std::vector<BundleWindow>& windows);

}  // namespace kinetrace::self_calibration

// The camera's path as a pose graph: steps, loops and fixes.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "camera_refinement.hpp"
#include "kinetrace/refinement/ceres_bundle_adjuster.hpp"

namespace kinetrace::batch {

/// The same place seen at two times.
struct Loop {
  std::size_t from_row = 0;  ///< The earlier one.
  std::size_t to_row = 0;
  Se3 T_from_to;
  Matrix6d information = Matrix6d::Zero();  ///< Inverse covariance of its left perturbation.
};

/// Positions of an antenna on the camera, on a map; see refinement::BatchFix.
struct MapFixes {
  Se3 T_map_world;  ///< Initial estimate.
  Eigen::Vector3d antenna_m = Eigen::Vector3d::Zero();
  std::vector<refinement::BatchFix> fixes = {};  ///< `before`, `after`: rows.
  double scale_sigma = 0.0;                      ///< Standard deviation of a common scale factor of the steps.
};

struct PathGraph {
  std::vector<Se3> T_world_cam;            ///< By row: the path that defines the steps.
  std::vector<Matrix6d> step_information;  ///< By row: inverse covariance of the step from the row before.
  std::vector<Loop> loops = {};
};

struct BentPath {
  std::vector<Se3> T_world_cam;
  Se3 T_map_world;     ///< If fixes were given.
  double scale = 1.0;  ///< Length of the path relative to its steps.
};

/// Corrections of a path beyond its steps.
struct PathCorrection {
  std::size_t loops = 0;
  double scale = 1.0;                     ///< Scale of the world relative to the run's stereo baseline.
  std::vector<std::string> results = {};  ///< Applied corrections, one line each.
};

/// The best-fitting path (Grisetti et al. 2010), with its first pose fixed: loops, and fixes if there are any, under a
/// Huber loss at three sigmas. Also estimates the map's pose in the world. Errors: those of the solver.
[[nodiscard]] Result<BentPath> bend_path(const StereoGeometry& geometry, const PathGraph& graph, const MapFixes& map,
                                         const AdjustmentOptions& options);

/// Moves the camera onto another path; points move with the frame that saw them last, at distances scaled with the
/// path. Returns the largest displacement of the camera (m).
double move_camera(BentPath path, RefinedCamera& camera);

}  // namespace kinetrace::batch

// The camera's path as a graph: its steps, and what else is known of it.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "camera_refinement.hpp"
#include "kinetrace/refinement/ceres_bundle_adjuster.hpp"

namespace kinetrace::batch {

/// One place seen at two times.
struct Loop {
  std::size_t from_row = 0;  ///< The earlier one.
  std::size_t to_row = 0;
  Se3 T_from_to;
  Matrix6d information = Matrix6d::Zero();  ///< Inverse covariance of its left perturbation.
};

/// Where an antenna on the camera was on a map; see refinement::BatchFix.
struct MapFixes {
  Se3 T_map_world;  ///< Where the search for it begins.
  Eigen::Vector3d antenna_m = Eigen::Vector3d::Zero();
  std::vector<refinement::BatchFix> fixes = {};  ///< `before`, `after`: rows.
  double scale_sigma = 0.0;                      ///< How far the steps may be off by a common factor.
};

struct PathGraph {
  std::vector<Se3> T_world_cam;            ///< By row: the path that tells its steps.
  std::vector<Matrix6d> step_information;  ///< By row: inverse covariance of the step from the row before.
  std::vector<Loop> loops = {};
};

struct BentPath {
  std::vector<Se3> T_world_cam;
  Se3 T_map_world;     ///< Where fixes were given.
  double scale = 1.0;  ///< By which the path is longer than its steps said.
};

/// What was done about a path beyond its steps.
struct PathCorrection {
  std::size_t loops = 0;
  double scale = 1.0;                     ///< By which everything is larger than the run's stereo baseline says.
  std::vector<std::string> results = {};  ///< What was done, one line each.
};

/// The path that fits best (Grisetti et al. 2010), its first pose where it is: loops, and fixes if there are any, under
/// a Huber loss at three sigmas. The map's place in the world is estimated with it. Errors: those of the solver.
[[nodiscard]] Result<BentPath> bend_path(const StereoGeometry& geometry, const PathGraph& graph, const MapFixes& map,
                                         const AdjustmentOptions& options);

/// Lays the camera onto another path; points go along with the frame that saw them last, as much farther from it as the
/// path is longer. Returns by how much the camera was moved at most (m).
double move_camera(BentPath path, RefinedCamera& camera);

}  // namespace kinetrace::batch

// Fits the camera's path to a reference, such as a receiver's fixes, by their uncertainty.
#pragma once

#include <cstddef>
#include <span>

#include "../path_graph.hpp"
#include "kinetrace/geo/alignment.hpp"

namespace kinetrace::batch {

struct ReferenceFit {
  geo::Alignment alignment;  ///< Of the final path.
  double moved_m = 0.0;      ///< Largest displacement of the path.
  double scale = 1.0;        ///< Scale of the world relative to the stereo baseline.
};

/// Bends and scales the path (scale sigma: config.path_drift) onto the fixes of a reference, each an individual factor
/// with the receiver's standard deviation and lever arm. Alternates two steps until convergence, since errors of the
/// path are no noise of the receiver: geo::align estimates T_map_world, the clocks' offset, outliers, noise and its
/// correlation time, which reduces the weight of each fix; then the path is bent. Errors: kBadFormat if geo::align
/// refuses the bent path with these fixes, but for the rotation about a straight path; those of the solver.
[[nodiscard]] Result<ReferenceFit> fit_to_reference(const recording::Run& run, std::span<const geo::Fix> fixes,
                                                    const geo::AlignmentConfig& config, const PathGraph& graph,
                                                    const AdjustmentOptions& options, RefinedCamera& camera);

}  // namespace kinetrace::batch

// A path of the camera that a reference holds: where a receiver was, as far as it knows.
#pragma once

#include <cstddef>
#include <span>

#include "../path_graph.hpp"
#include "kinetrace/geo/alignment.hpp"

namespace kinetrace::batch {

struct ReferenceFit {
  geo::Alignment alignment;  ///< Of the path as it is now.
  double moved_m = 0.0;      ///< By which the path was moved at most.
  double scale = 1.0;        ///< By which everything is larger than the stereo baseline says.
};

/// Bends and scales the path, by config.path_drift (one sigma), onto the fixes of a reference, each as a factor of its
/// own with the receiver's standard deviation and lever arm. What that is worth is asked of the residuals: aligned by
/// geo::align, which finds T_map_world, the clocks' offset, outliers, noise and its correlation time, by which a fix
/// counts less; then bent; and again, since what the path was off by is no noise of the receiver. Errors: kBadFormat
/// where the fixes are too few, or the motion does not tell their clock's offset; those of the solver.
[[nodiscard]] Result<ReferenceFit> fit_to_reference(const recording::Run& run, std::span<const geo::Fix> fixes,
                                                    const geo::AlignmentConfig& config, const PathGraph& graph,
                                                    const AdjustmentOptions& options, RefinedCamera& camera);

}  // namespace kinetrace::batch

// Places that the camera saw twice pull its path together.
#pragma once

#include "../camera_refinement.hpp"
#include "place_matcher.hpp"

namespace kinetrace::batch {

/// A path whose steps are as firm as `step_information` says, bent so that both views of each loop agree (Grisetti et
/// al. 2010), loops under a Huber loss at three sigmas. `T_world_cam` is adjusted in place; its first pose stays.
/// Errors: those of the solver.
[[nodiscard]] Status bend_path(const StereoGeometry& geometry, std::span<const Matrix6d> step_information,
                               std::span<const Loop> loops, const AdjustmentOptions& options,
                               std::span<Se3> T_world_cam);

struct ClosedLoops {
  std::size_t loops = 0;
  double moved_m = 0.0;  ///< By which the path was moved at most.
};

/// Finds the loops of the path and bends it; points go along with the frame that saw them last. Pictures are only read
/// where poses say that a place may have been seen twice. `progress` gets the part that is done.
/// Errors: those of reading observations and pictures, and of the solver.
[[nodiscard]] Result<ClosedLoops> close_loops(const recording::Run& run, const PairReader& read,
                                              const AdjustmentOptions& options, RefinedCamera& camera,
                                              const std::function<void(double)>& progress);

}  // namespace kinetrace::batch

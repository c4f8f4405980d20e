// Constraints on the camera's path beyond neighbouring frames: loops, and a reference.
#pragma once

#include "cli/failure.hpp"
#include "pair_reader.hpp"
#include "path_graph.hpp"
#include "reference/reference_factors.hpp"
#include "refine_progress.hpp"

namespace kinetrace::batch {

/// Settings of the loop search; without a reader, there is none.
struct LoopSearch {
  PairReader read;
  RefineProgress& progress;
};

/// Closes loops, and constrains the path by the reference, if there is one. Errors: those of reading the run's
/// observations and the recording's images, and of the solver.
[[nodiscard]] app::Outcome<PathCorrection> correct_path(const recording::Run& run, const MeasuredBackground& measured,
                                                        const LoopSearch& search, const HoldPath& hold,
                                                        const AdjustmentOptions& adjustment, RefinedCamera& camera);

}  // namespace kinetrace::batch

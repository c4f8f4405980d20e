// The camera's path beyond what neighbouring frames tell of it: places seen twice, and a reference.
#pragma once

#include "cli/failure.hpp"
#include "path_graph.hpp"
#include "reference/reference_factors.hpp"
#include "refine_progress.hpp"
#include "refinement/refine_options.hpp"

namespace kinetrace::batch {

/// Closes loops, if they are asked for, and holds the path by the reference, if there is one. Errors: those of reading
/// the recording's observations, of its pictures where they were asked for by name, and of the solver.
[[nodiscard]] app::Outcome<PathCorrection> correct_path(const recording::Run& run, const app::RefineOptions& options,
                                                        const AdjustmentOptions& adjustment, const HoldPath& hold,
                                                        RefinedCamera& camera, RefineProgress& progress);

}  // namespace kinetrace::batch

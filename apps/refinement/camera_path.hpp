// The camera's path beyond what neighbouring frames tell of it: places seen twice, and a reference.
#pragma once

#include "cli/failure.hpp"
#include "path_graph.hpp"
#include "refine_progress.hpp"
#include "refinement/refine_options.hpp"

namespace kinetrace::batch {

/// Closes loops and holds the path by the reference, as asked. Errors: those of reading the recording's observations,
/// pictures where they were asked for by name, and the reference; of the solver.
[[nodiscard]] app::Outcome<PathCorrection> correct_path(const recording::Run& run, const app::RefineOptions& options,
                                                        const AdjustmentOptions& adjustment, RefinedCamera& camera,
                                                        RefineProgress& progress);

}  // namespace kinetrace::batch

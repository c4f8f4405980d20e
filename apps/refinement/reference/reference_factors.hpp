// What `--reference` asks of a refinement.
#pragma once

#include <string>

#include "../path_graph.hpp"
#include "cli/failure.hpp"
#include "map/reference_options.hpp"

namespace kinetrace::batch {

/// Reads the reference and bends the camera's path onto it; returns what the user should know of it, one line.
/// Errors: kUsage, those of reading it, kBadData where it does not determine where the path lies.
[[nodiscard]] app::Outcome<std::string> hold_by_reference(const recording::Run& run,
                                                          const app::ReferenceOptions& options, const PathGraph& graph,
                                                          const AdjustmentOptions& adjustment, RefinedCamera& camera);

}  // namespace kinetrace::batch

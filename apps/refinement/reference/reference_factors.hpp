// What `--reference` asks of a refinement.
#pragma once

#include <string>

#include "../path_graph.hpp"
#include "cli/failure.hpp"
#include "map/reference_options.hpp"

namespace kinetrace::batch {

struct HeldPath {
  double scale = 1.0;  ///< By which everything is larger than the run's stereo baseline says.
  std::string result;  ///< What the user should know of it, one line.
};

/// Reads the reference and bends the camera's path onto it.
/// Errors: kUsage, those of reading it, kBadData where it does not determine where the path lies.
[[nodiscard]] app::Outcome<HeldPath> hold_by_reference(const recording::Run& run, const app::ReferenceOptions& options,
                                                       const PathGraph& graph, const AdjustmentOptions& adjustment,
                                                       RefinedCamera& camera);

}  // namespace kinetrace::batch

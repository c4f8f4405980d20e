// What `--reference` asks of a refinement.
#pragma once

#include <functional>
#include <string>

#include "../path_graph.hpp"
#include "cli/failure.hpp"
#include "map/reference_options.hpp"

namespace kinetrace::batch {

struct HeldPath {
  double scale = 1.0;  ///< By which everything is larger than the run's stereo baseline says.
  std::string result;  ///< What the user should know of it, one line.
};

/// Bends the camera's path onto the reference. Errors: kBadData where it does not determine where the path lies.
using HoldPath = std::function<app::Outcome<HeldPath>(const PathGraph& graph, RefinedCamera& camera)>;

/// Reads the reference, before the work begins; none where none was asked for. `run` and `adjustment` are to outlive
/// what it returns. Errors: kUsage, those of reading it.
[[nodiscard]] app::Outcome<HoldPath> read_reference(const recording::Run& run, const app::ReferenceOptions& options,
                                                    const AdjustmentOptions& adjustment);

}  // namespace kinetrace::batch

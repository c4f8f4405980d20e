// Option `--reference` of a refinement.
#pragma once

#include <functional>
#include <string>

#include "../path_graph.hpp"
#include "cli/failure.hpp"
#include "map/reference_options.hpp"

namespace kinetrace::batch {

struct HeldPath {
  double scale = 1.0;  ///< Scale of the world relative to the run's stereo baseline.
  std::string result;  ///< For the user, one line.
};

/// Bends the camera's path onto the reference. Errors: kBadData if it does not determine the path's place.
using HoldPath = std::function<app::Outcome<HeldPath>(const PathGraph& graph, RefinedCamera& camera)>;

/// Reads the reference, before the work begins; none without a reference option. `run` and `adjustment` must outlive
/// the result. Errors: kUsage, those of reading it.
[[nodiscard]] app::Outcome<HoldPath> read_reference(const recording::Run& run, const app::ReferenceOptions& options,
                                                    const AdjustmentOptions& adjustment);

}  // namespace kinetrace::batch

// `kinetrace refine`.
#pragma once

#include "refinement/refine_options.hpp"

namespace kinetrace::batch {

/// Refines a run into another folder. Returns the exit code.
int refine_command(const app::RefineOptions& options);

}  // namespace kinetrace::batch

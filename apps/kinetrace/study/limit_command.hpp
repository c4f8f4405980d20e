// `study limit`.
#pragma once

#include "cli/commands.hpp"

namespace kinetrace::app {

/// Measures errors of objects relative to their Cramer-Rao bounds.
[[nodiscard]] Action add_limit(CLI::App& command);

}  // namespace kinetrace::app

// `kinetrace map`: a run and a reference in, files for maps out.
#pragma once

#include "map/map_options.hpp"

namespace kinetrace::map {

/// Returns the exit code; errors have been printed.
[[nodiscard]] int map_command(const app::MapOptions& options);

}  // namespace kinetrace::map

// `kinetrace map --reference navsatfix:TOPIC`: follows a live run, and publishes its position on the map.
#pragma once

#include "cli/failure.hpp"
#include "map/map_options.hpp"

namespace kinetrace::map {

/// Until a signal or the requested time; the exit code. Prints the state of the alignment.
[[nodiscard]] app::Outcome<int> follow_run(const app::MapOptions& options);

}  // namespace kinetrace::map

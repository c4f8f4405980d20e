// `kinetrace map --reference navsatfix:TOPIC`: follows a run that publishes, and publishes where it is on the map.
#pragma once

#include "cli/failure.hpp"
#include "map/map_options.hpp"

namespace kinetrace::map {

/// Until a signal or the time that was asked for; the exit code. Prints how the alignment stands.
[[nodiscard]] app::Outcome<int> follow_run(const app::MapOptions& options);

}  // namespace kinetrace::map

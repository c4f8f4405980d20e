// The network as the command line says.
#pragma once

#include "dds/dds_options.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/link.hpp"
#include "live/clocks.hpp"

namespace kinetrace::app {

/// The file, if there is one, and the options above it; checked as a whole. Errors: those of load_publish_config.
[[nodiscard]] Result<publishing::PublishConfig> network_config(const NetworkOptions& options);

/// Looks after the link and waits for messages, 100 ms at most. Prints what the user should hear.
void serve(publishing::Link& link);

}  // namespace kinetrace::app

// DDS configuration and link from the command line.
#pragma once

#include "dds/dds_options.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/link.hpp"
#include "live/clocks.hpp"

namespace kinetrace::app {

/// Reads the file, if any, and applies the options; checked as a whole. Errors: those of load_publish_config.
[[nodiscard]] Result<publishing::PublishConfig> network_config(const NetworkOptions& options);

/// Supervises the link, prints its notices and waits for messages, 100 ms at most.
void serve(publishing::Link& link);

}  // namespace kinetrace::app

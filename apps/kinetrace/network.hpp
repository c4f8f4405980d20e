// The network as the command line says.
#pragma once

#include <chrono>
#include <cstdint>

#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/link.hpp"
#include "network_options.hpp"

namespace kinetrace::app {

/// The file, if there is one, and the options above it; checked as a whole. Errors: those of load_publish_config.
[[nodiscard]] Result<publishing::PublishConfig> network_config(const NetworkOptions& options);

[[nodiscard]] inline std::int64_t steady_time_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}
[[nodiscard]] inline std::int64_t system_time_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// Looks after the link and waits for messages, 100 ms at most. Prints what the user should hear.
void serve(publishing::Link& link);

}  // namespace kinetrace::app

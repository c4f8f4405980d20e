// What doctor finds out about DDS.
#pragma once

#include <string>

namespace kinetrace::app {

struct NetworkFinding {
  bool holds = false;
  std::string detail;  ///< With the remedy where it does not hold.
};

/// Takes part in the domain for a moment. `file` is that of a run's --publish; empty: the defaults.
[[nodiscard]] NetworkFinding examine_network(const std::string& file);

}  // namespace kinetrace::app

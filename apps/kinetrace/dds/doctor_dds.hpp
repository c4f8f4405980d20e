// DDS checks of `kinetrace doctor`.
#pragma once

#include <string>

namespace kinetrace::app {

struct NetworkFinding {
  bool holds = false;
  std::string detail;  ///< With the remedy if the check failed.
};

/// Joins the domain briefly. `file`: that of a run's --publish; empty: the defaults.
[[nodiscard]] NetworkFinding examine_network(const std::string& file);

}  // namespace kinetrace::app

// Options of the reference for the camera's positions. Shared by `kinetrace map` and `kinetrace refine`.
#pragma once

#include <optional>
#include <string>

// NOLINTNEXTLINE(readability-identifier-naming): theirs.
namespace CLI {
class App;
}

namespace kinetrace::app {

struct ReferenceOptions {
  std::string source;  ///< "FORMAT:PATH", or "navsatfix:TOPIC".
  int dof = 6;
  std::string lever_arm_m = "0,0,0";
  std::string origin;  ///< "LATITUDE,LONGITUDE,HEIGHT"; empty: in the middle of the reference.
  std::optional<double> time_offset_s;
  std::optional<double> max_time_offset_s;
  double drift_percent = 0.2;
};

/// All options except `--reference` itself.
void add_reference_options(CLI::App& command, ReferenceOptions& options);

}  // namespace kinetrace::app

// Options of `kinetrace map`: shared by the command, which only passes them on, and the map program.
#pragma once

#include <filesystem>
#include <string>

#include "map/reference_options.hpp"

// NOLINTNEXTLINE(readability-identifier-naming): theirs.
namespace CLI {
class App;
}

namespace kinetrace::app {

/// The map program and its package.
inline constexpr const char* kMapProgram = "kinetrace-map";
inline constexpr const char* kMapPackage = "kinetrace-map";

struct MapOptions {
  std::filesystem::path run;  ///< Empty: a run in progress, over DDS.
  ReferenceOptions reference;
  std::string publish;        ///< File of the running run's --publish; empty: the defaults.
  double seconds = 0.0;       ///< Duration for a run in progress; 0: until a signal.
  std::filesystem::path out;  ///< Empty: `map` in the run folder.
  bool json = false;
  bool quiet = false;
};

void add_map_options(CLI::App& command, MapOptions& options);

}  // namespace kinetrace::app

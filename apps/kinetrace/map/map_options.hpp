// What `kinetrace map` is asked for. Known to the command, which only passes it on, and to the program that does it.
#pragma once

#include <filesystem>
#include <string>

#include "map/reference_options.hpp"

// NOLINTNEXTLINE(readability-identifier-naming): theirs.
namespace CLI {
class App;
}

namespace kinetrace::app {

/// The program that makes maps, and the package that brings it.
inline constexpr const char* kMapProgram = "kinetrace-map";
inline constexpr const char* kMapPackage = "kinetrace-map";

struct MapOptions {
  std::filesystem::path run;  ///< Empty: a run that goes on, over DDS.
  ReferenceOptions reference;
  std::string publish;        ///< The file that a run that goes on publishes by; empty: its defaults.
  double seconds = 0.0;       ///< Of such a run: ends after so much time; 0: at a signal.
  std::filesystem::path out;  ///< Empty: `map` in the run folder.
  bool json = false;
  bool quiet = false;
};

void add_map_options(CLI::App& command, MapOptions& options);

}  // namespace kinetrace::app

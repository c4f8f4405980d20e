// Starts the map program: a board that only runs Kinetrace need not install its libraries.
#include <memory>

#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/companion.hpp"
#include "map/map_options.hpp"

namespace kinetrace::app {

Action add_map(CLI::App& command) {
  const auto options = std::make_shared<MapOptions>();
  add_map_options(command, *options);
  return forward_options(command, options, {kMapProgram, kMapPackage, "making maps"});
}

}  // namespace kinetrace::app

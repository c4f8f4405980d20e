// Starts the refinement program: a board that only runs Kinetrace need not install its libraries.
#include <memory>

#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "refinement/refine_options.hpp"

namespace kinetrace::app {

Action add_refine(CLI::App& command) {
  const auto options = std::make_shared<RefineOptions>();
  add_refine_options(command, *options);
  return forward_options(command, options, kRefineCompanion);
}

}  // namespace kinetrace::app

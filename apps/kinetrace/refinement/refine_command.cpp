// Starts the program that refines whole recordings: a board that only runs does not carry what that takes.
#include <memory>

#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "refinement/refine_options.hpp"

namespace kinetrace::app {

Action add_refine(CLI::App& command) {
  const auto options = std::make_shared<RefineOptions>();
  add_refine_options(command, *options);
  return pass_on(command, options, kRefineCompanion);
}

}  // namespace kinetrace::app

// Starts the program that calibrates: a board that only runs does not carry what estimation takes.
#include <CLI/CLI.hpp>

#include "calibration/calibrate_options.hpp"
#include "cli/commands.hpp"
#include "cli/companion.hpp"

namespace kinetrace::app {

Action add_calibrate(CLI::App& command) {
  const auto options = std::make_shared<CalibrateOptions>();
  add_calibrate_options(command, *options);
  const Action action = become_companion(command, {kCalibrateProgram, kCalibratePackage, "calibrating"});
  return [options, action] { return action(); };
}

}  // namespace kinetrace::app

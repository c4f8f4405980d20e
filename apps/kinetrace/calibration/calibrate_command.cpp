// Starts the calibration program: a board that only runs Kinetrace need not install the libraries for estimation.
#include <memory>

#include <CLI/CLI.hpp>

#include "calibration/calibrate_options.hpp"
#include "cli/commands.hpp"
#include "cli/companion.hpp"

namespace kinetrace::app {

Action add_calibrate(CLI::App& command) {
  const auto options = std::make_shared<CalibrateOptions>();
  add_calibrate_options(command, *options);
  return forward_options(command, options, {kCalibrateProgram, kCalibratePackage, "calibrating"});
}

}  // namespace kinetrace::app

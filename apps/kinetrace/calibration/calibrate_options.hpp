// What `kinetrace calibrate` is asked for. Known to the command, which only passes it on, and to the program that does
// it.
#pragma once

#include <filesystem>
#include <string>

#include "cli/shared_options.hpp"

namespace kinetrace::app {

/// The program that calibrates, and the package that brings it.
inline constexpr const char* kCalibrateProgram = "kinetrace-calibrate";
inline constexpr const char* kCalibratePackage = "kinetrace-calibration";

struct CalibrateOptions {
  SourceOptions source;
  UntilOptions until;
  std::string target;           ///< As parse_target understands it; empty with `self`.
  std::string self;             ///< "LAYOUT:PATH" of a recording without a target; empty: with one.
  double baseline_m = 0.0;      ///< Known beside that recording.
  std::string lens = "radtan";  ///< A name of kLensNames.
  std::filesystem::path out;    ///< Folder for the calibration and its report.
  std::filesystem::path draw;   ///< The target to print; nothing is calibrated then.
  bool quiet = false;
};

void add_calibrate_options(CLI::App& command, CalibrateOptions& options);

}  // namespace kinetrace::app

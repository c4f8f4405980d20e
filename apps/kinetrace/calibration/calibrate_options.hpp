// Options of `kinetrace calibrate`: shared by the command, which only passes them on, and the program that calibrates.
#pragma once

#include <filesystem>
#include <string>

#include "cli/shared_options.hpp"

namespace kinetrace::app {

/// The calibration program and its package.
inline constexpr const char* kCalibrateProgram = "kinetrace-calibrate";
inline constexpr const char* kCalibratePackage = "kinetrace-calibration";

struct CalibrateOptions {
  SourceOptions source;
  UntilOptions until;
  std::string target;           ///< Syntax of parse_target; empty with `self`.
  std::string self;             ///< "LAYOUT:PATH" of a recording without a target; empty: calibrate with a target.
  double baseline_m = 0.0;      ///< Known baseline of that recording.
  std::string lens = "radtan";  ///< A name of kLensNames.
  std::filesystem::path out;    ///< Folder for the calibration and its report.
  std::filesystem::path draw;   ///< Write the target to print here instead of calibrating.
  bool quiet = false;
};

void add_calibrate_options(CLI::App& command, CalibrateOptions& options);

}  // namespace kinetrace::app

#include "calibration/calibrate_options.hpp"

#include <CLI/CLI.hpp>

#include "cli/option_checks.hpp"

namespace kinetrace::app {

void add_calibrate_options(CLI::App& command, CalibrateOptions& options) {
  options.source.uncalibrated = true;
  add_source_options(command, options.source);
  auto* const self = command.get_option_group("Source")
                         ->add_option("--self", options.self,
                                      "A recording of any scene, in motion: the calibration follows from it and the "
                                      "length of the baseline alone")
                         ->type_name("LAYOUT:PATH");
  // These choose among the contents of either recording.
  for (const char* name : {"--sequence", "--cameras"}) {
    command.get_option(name)->remove_needs(command.get_option("--dataset"));
    command.get_option(name)->excludes(command.get_option("--camera"));
  }
  auto* const known = command.add_option_group("Known", "Known geometry: one of");
  known->require_option(1);
  known->add_option("--baseline", options.baseline_m, "With --self: distance of the two lenses")
      ->type_name("METRES")
      ->check(number_within(0.001, 10.0))
      ->needs(self);
  known
      ->add_option(
          "--target", options.target,
          "Target in view: chessboard:9x6:0.03 (inner corners, side of a square in metres), "
          "charuco:8x6:0.04:0.03:DICT_4X4_100 (squares, their side, that of a marker), aprilgrid:6x6:0.088:0.3 "
          "(tags, their side, gaps as part of it), or a target file of Kalibr")
      ->type_name("TARGET")
      ->excludes(self);
  command
      .add_option(
          "--lens", options.lens,
          "With a target, lens model: radtan (k1 k2 p1 p2), radtan5 (and k3), rational (and k4 to k6) or fisheye "
          "(equidistant); --self takes radial-tangential lenses only")
      ->check(CLI::IsMember({"radtan", "radtan5", "rational", "fisheye"}))
      ->capture_default_str()
      ->excludes(self);
  command
      .add_option("--out", options.out,
                  "Folder for calibration.yaml (OpenCV), camchain.yaml (Kalibr), calibration.json and calibration.png")
      ->type_name("DIR");
  command.add_option("--draw", options.draw, "Writes the target as an SVG to print in its true size, and ends")
      ->type_name("FILE")
      ->check(named_as(".svg"));
  // Drawing a target takes no images.
  command.get_option_group("Source")->require_option(0, 1);
  add_until_options(command, options.until);
  // A recording without a target is read once, as it is; its lenses are radial-tangential.
  for (const char* unused : {"--loop", "--fault", "--seconds"}) {
    command.get_option(unused)->excludes(self);
  }
  command.add_flag("--quiet", options.quiet, "Prints nothing but warnings and errors");
}

}  // namespace kinetrace::app

#include "map/reference_options.hpp"

#include <CLI/CLI.hpp>

#include "cli/option_checks.hpp"

namespace kinetrace::app {

void add_reference_options(CLI::App& command, ReferenceOptions& options) {
  command
      .add_option("--dof", options.dof,
                  "Degrees of freedom of the alignment: 6, rotation and position; 4, heading and position of a camera "
                  "that was level in its "
                  "first frame")
      ->needs("--reference")
      ->check(CLI::IsMember({4, 6}))
      ->capture_default_str();
  command
      .add_option("--lever-arm", options.lever_arm_m,
                  "Position of the antenna from the left camera: right, down, forward")
      ->needs("--reference")
      ->type_name("X,Y,Z")
      ->capture_default_str();
  command
      .add_option("--time-offset", options.time_offset_s,
                  "Camera's clock minus the reference's, initial value; without it, 0, or, with navsatfix, as if the "
                  "reference had the clock of the run's machine")
      ->needs("--reference")
      ->type_name("SECONDS")
      ->check(number_within(-4e9, 4e9));
  command
      .add_option(
          "--max-time-offset", options.max_time_offset_s,
          "Largest difference from that value; 0: the offset is known exactly. Without it, 10, or, with navsatfix, 1")
      ->needs("--reference")
      ->type_name("SECONDS")
      ->check(number_within(0.0, 3600.0));
  command
      .add_option("--drift", options.drift_percent,
                  "Drift of the run's path as a share of its length, for the standard deviations")
      ->needs("--reference")
      ->type_name("PERCENT")
      ->check(number_within(0.0, 100.0))
      ->capture_default_str();
  command
      .add_option(
          "--origin", options.origin,
          "Origin of the map's metres in WGS84; for euroc, where its metres begin. Without it, the middle of the "
          "reference; at most 100 km from the fixes")
      ->needs("--reference")
      ->type_name("LAT,LON,HEIGHT");
}

}  // namespace kinetrace::app

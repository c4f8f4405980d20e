#include "map/map_options.hpp"

#include <CLI/CLI.hpp>

#include "cli/option_checks.hpp"

namespace kinetrace::app {

void add_map_options(CLI::App& command, MapOptions& options) {
  command.add_option("RUN", options.run, "Run folder; with navsatfix, none: a run that goes on and publishes");
  command
      .add_option("--reference", options.reference,
                  "Where the camera was: oxts (KITTI raw), nmea (GGA and RMC), gpx, euroc (ground truth as CSV) or csv "
                  "(columns timestamp_ns, latitude, longitude, height); navsatfix:TOPIC, a topic of ROS 2")
      ->type_name("FORMAT:PATH")
      ->required();
  command
      .add_option("--publish", options.publish,
                  "With navsatfix: the file that the run publishes by; config/dds holds examples")
      ->type_name("FILE");
  command.add_option("--seconds", options.seconds, "With navsatfix: ends after so much time; without it, at Ctrl-C")
      ->type_name("S")
      ->check(number_within(0.001, 1e9));
  command.add_option("--out", options.out, "Folder for the files; without it, map in the run folder")->type_name("DIR");
  command
      .add_option(
          "--dof", options.dof,
          "What is aligned: 6, rotation and position; 4, heading and position of a camera that was level in its "
          "first frame")
      ->check(CLI::IsMember({4, 6}))
      ->capture_default_str();
  command
      .add_option("--lever-arm", options.lever_arm_m,
                  "Where the antenna is, from the left camera: right, down, forward")
      ->type_name("X,Y,Z")
      ->capture_default_str();
  command
      .add_option(
          "--time-offset", options.time_offset_s,
          "Camera's clock minus the reference's, where the search for it begins; without it, 0, or, with navsatfix, "
          "as if the reference had the clock of the run's machine")
      ->type_name("SECONDS")
      ->check(number_within(-4e9, 4e9));
  command
      .add_option("--max-time-offset", options.max_time_offset_s,
                  "Search as far from there; 0: the offset is known exactly. Without it, 10, or, with navsatfix, 1")
      ->type_name("SECONDS")
      ->check(number_within(0.0, 3600.0));
  command
      .add_option("--drift", options.drift_percent,
                  "What the run's path may be off by, as a share of its length; for the standard deviations")
      ->type_name("PERCENT")
      ->check(number_within(0.0, 100.0))
      ->capture_default_str();
  command
      .add_option(
          "--origin", options.origin,
          "Origin of the map's metres in WGS84; for euroc, where its metres begin. Without it, the middle of the "
          "reference")
      ->type_name("LAT,LON,HEIGHT");
  command.add_flag("--json", options.json,
                   "Prints map.json instead of a summary; with navsatfix, one line of it for each alignment");
  command.add_flag("--quiet", options.quiet, "Prints nothing but warnings and errors");
}

}  // namespace kinetrace::app

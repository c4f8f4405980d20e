#include "map/map_options.hpp"

#include <CLI/CLI.hpp>

#include "cli/option_checks.hpp"

namespace kinetrace::app {

void add_map_options(CLI::App& command, MapOptions& options) {
  command.add_option("RUN", options.run, "Run folder; with navsatfix, none: a run in progress that publishes");
  command
      .add_option("--reference", options.reference.source,
                  "Reference for the camera's positions: oxts (KITTI raw), nmea (GGA and RMC), gpx, euroc (ground "
                  "truth as CSV) or csv "
                  "(columns timestamp_ns, latitude, longitude, height); navsatfix:TOPIC, a topic of ROS 2")
      ->type_name("FORMAT:PATH")
      ->required();
  command
      .add_option("--publish", options.publish,
                  "With navsatfix: file of the run's --publish; config/dds holds examples")
      ->type_name("FILE");
  command.add_option("--seconds", options.seconds, "With navsatfix: ends after this time; without it, at Ctrl-C")
      ->type_name("S")
      ->check(number_within(0.001, 1e9));
  command.add_option("--out", options.out, "Folder for the files; without it, map in the run folder")->type_name("DIR");
  add_reference_options(command, options.reference);
  command.add_flag("--json", options.json,
                   "Prints map.json instead of a summary; with navsatfix, one line of it for each alignment");
  command.add_flag("--quiet", options.quiet, "Prints nothing but warnings and errors");
}

}  // namespace kinetrace::app

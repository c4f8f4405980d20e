#include "refinement/refine_options.hpp"

#include <CLI/CLI.hpp>

namespace kinetrace::app {

void add_refine_options(CLI::App& command, RefineOptions& options) {
  command.add_option("RUN", options.run, "Run folder, with observations.bin (output.observations)")->required();
  command
      .add_option("--out", options.out, "Run folder for the refined run; made, or replaced if it is an earlier run's")
      ->type_name("DIR")
      ->required();
  command.add_option("--dataset", options.dataset, "Present location of the recording, if it has moved since the run")
      ->type_name("LAYOUT:PATH");
  command.add_flag("!--no-images", options.images,
                   "Does not use the recording's images: no new measurement of points, no search for loops");
  command.add_flag("!--no-loops", options.loops, "Does not search for places that the camera visited twice");
  command
      .add_option("--reference", options.reference.source,
                  "Reference for the camera's positions, which constrains its path: oxts (KITTI raw), nmea (GGA and "
                  "RMC), gpx, euroc (ground "
                  "truth as CSV) or csv (columns timestamp_ns, latitude, longitude, height)")
      ->type_name("FORMAT:PATH");
  add_reference_options(command, options.reference);
  command.add_flag("--json", options.json, "Prints run.json on standard output instead of the summary");
  command.add_flag("--quiet", options.quiet, "Prints nothing but warnings and errors");
}

}  // namespace kinetrace::app

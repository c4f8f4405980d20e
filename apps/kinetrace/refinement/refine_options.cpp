#include "refinement/refine_options.hpp"

#include <CLI/CLI.hpp>

namespace kinetrace::app {

void add_refine_options(CLI::App& command, RefineOptions& options) {
  command.add_option("RUN", options.run, "Run folder, with observations.bin (output.observations)")->required();
  command
      .add_option("--out", options.out, "Run folder for the refined run; made, or replaced if it is an earlier run's")
      ->type_name("DIR")
      ->required();
  command.add_option("--dataset", options.dataset, "Where the recording lies now, if not where the run was made")
      ->type_name("LAYOUT:PATH");
  command.add_flag("!--no-images", options.images,
                   "Does without the recording's images: points are not measured again, loops not looked for");
  command.add_flag("!--no-loops", options.loops, "Does not look for places that the camera saw twice");
  command
      .add_option("--reference", options.reference.source,
                  "Where the camera was, to hold its path by: oxts (KITTI raw), nmea (GGA and RMC), gpx, euroc (ground "
                  "truth as CSV) or csv (columns timestamp_ns, latitude, longitude, height)")
      ->type_name("FORMAT:PATH");
  add_reference_options(command, options.reference);
  command.add_flag("--json", options.json, "Prints run.json on standard output instead of the summary");
  command.add_flag("--quiet", options.quiet, "Prints nothing but warnings and errors");
}

}  // namespace kinetrace::app

// The main command.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/companion.hpp"
#include "cli/messages.hpp"
#include "kinetrace/recording/run_recorder.hpp"
#include "live/thread_stacks.hpp"
#include "refinement/refine_options.hpp"
#include "run/run_components.hpp"
#include "run/run_options.hpp"
#include "run/run_report.hpp"
#include "run/run_session.hpp"
#include "run/run_setup.hpp"

namespace kinetrace::app {
namespace {

Outcome<RunReport> run(const RunOptions& options) {
  Outcome<RunSetup> setup = RunSetup::create(options);
  if (!setup) {
    return Unexpected(setup.error());
  }
  if (const Status limited = limit_thread_stacks(); !limited) {
    return failure(limited.error());
  }
  Arena arena(setup->memory.arena.total_bytes());
  Outcome<RunComponents> components = make_components(*setup, arena);
  if (!components) {
    return Unexpected(components.error());
  }
  RunSession session(*setup, *components);
  if (const Status begun = session.begin(arena); !begun) {
    return failure(begun.error());
  }
  if (const Status ended = session.finish(session.play()); !ended) {
    return failure(ended.error());
  }
  return std::move(session.report());
}

int run_command(const RunOptions& options) {
  const Outcome<RunReport> outcome = run(options);
  if (!outcome) {
    return report(outcome.error());
  }
  outcome->print();
  return outcome->summary().exit_status;
}

// The online run stays beside the refined one, as DIR.online.
int run_and_refine(const RunOptions& options) {
  if (options.refine.empty()) {
    return run_command(options);
  }
  if (const Status there = check(kRefineCompanion); !there) {
    return report(to_failure(there.error()));
  }
  if (const Status usable = recording::RunRecorder::check_folder(options.out); !usable) {
    return report({ExitCode::kCannotCreate, usable.error().message});
  }
  RunOptions online = options;
  online.out = (options.out.has_filename() ? options.out : options.out.parent_path()).string() + ".online";
  if (const int failed = run_command(online); failed != 0) {
    return failed;
  }
  std::vector<std::string> arguments{online.out.string(), "--out", options.out.string()};
  if (options.quiet || options.json) {
    arguments.emplace_back("--quiet");
  }
  return exec_companion(kRefineCompanion, arguments);
}

void add_options(CLI::App& run, RunOptions& options) {
  add_source_options(run, options.source);
  run.add_option(
         "--segmentation", options.segmentation,
         "Where objects come from: auto[:MODEL.yaml] (the default: motion and a neural network together, motion "
         "alone where none can be loaded or memory.budget_mib has no room for it), motion, none (they are not "
         "looked for), mask files (KITTI MOTS PNG) as masks:LEFT_DIR[,RIGHT_DIR], a neural network alone as "
         "onnx[:MODEL.yaml], or dds: masks that another process sends, see kinetrace masks")
      ->type_name("HOW");
  add_config_options(run, options.config);
  run.add_option("--out", options.out, "Run folder; made, or replaced if it is an earlier run's")
      ->type_name("DIR")
      ->required();
  run.add_option(
         "--refine", options.refine,
         "batch: refines the run as a whole after its end, see kinetrace refine; DIR is the refined run then, "
         "DIR.online the one before. Takes 4000 features, unless --set says otherwise, and memory and time accordingly")
      ->type_name("HOW")
      ->check(CLI::IsMember({"batch"}));
  run.add_flag("--images", options.images,
               "Also writes the rectified left images into the run folder: those that its COLMAP models are of");
  run.add_option(
         "--save-calibration", options.save_calibration,
         "Writes the calibration as the run has corrected it, in OpenCV's YAML, for the next start; replaces an "
         "earlier calibration in this format, no other file")
      ->type_name("FILE");
  add_until_options(run, options.until);
  CLI::Option* raw =
      run.add_option("--record", options.raw.out, "Also records the raw images, into a new folder")->type_name("DIR");
  add_raw_options(run, options.raw, raw);
  add_publish_option(run, options.publish);
  run.add_flag("--json", options.json, "Prints run.json on standard output instead of the summary");
  run.add_flag("--quiet", options.quiet, "Prints nothing but warnings and errors");
}

}  // namespace

Action add_run(CLI::App& command) {
  return bind_options(command, add_options, run_and_refine);
}

}  // namespace kinetrace::app

// The main command.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/companion.hpp"
#include "cli/messages.hpp"
#include "kinetrace/core/files.hpp"
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

namespace fs = std::filesystem;

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

/// With a name of its own, which "." and "a/" do not have.
fs::path named_folder(const fs::path& out) {
  std::error_code error;
  const fs::path folder = fs::absolute(out, error).lexically_normal();
  return folder.has_filename() ? folder : folder.parent_path();
}

int refine_batch(const RunOptions& options, const fs::path& online) {
  std::vector<std::string> arguments{"--out=" + named_folder(options.out).string()};
  if (options.json) {
    arguments.emplace_back("--json");
  }
  if (options.json || options.quiet) {
    arguments.emplace_back("--quiet");
  }
  arguments.emplace_back("--");
  arguments.push_back(online.string());
  return exec_companion(kRefineCompanion, arguments);
}

/// Each would make the other's folder look like someone else's.
std::optional<Failure> check_record_place(const fs::path& record, const fs::path& results) {
  if (record.empty() || !is_inside(results, record)) {
    return std::nullopt;
  }
  return Failure{ExitCode::kUsage, "--record " + record.string() + ": " +
                                       (is_inside(record, results) ? "is" : "holds") + " the folder of the results, " +
                                       results.string() +
                                       "; results and recording cannot share a folder, name another one"};
}

/// The online run stays beside the refined one, as DIR.online.
int run_and_refine(const RunOptions& options) {
  const fs::path online_out = named_folder(options.out).string() + ".online";
  for (const fs::path& results : {options.out, options.refine.empty() ? options.out : online_out}) {
    if (const auto shared = check_record_place(options.raw.out, results)) {
      return report(*shared);
    }
  }
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
  online.out = online_out;
  const Outcome<RunReport> outcome = run(online);
  if (!outcome) {
    return report(outcome.error());
  }
  if (const int failed = outcome->summary().exit_status; failed != 0) {
    outcome->print();
    print_warning(options.out.string() + ": was not written, since the run ended early; what it computed is in " +
                  online.out.string());
    return failed;
  }
  if (options.json) {
    outcome->print_warnings();  // Of both runs, the refined one's run.json is printed.
  } else {
    outcome->print();
  }
  return refine_batch(options, online.out);
}

void add_options(CLI::App& run, RunOptions& options) {
  add_source_options(run, options.source);
  run.add_option("--segmentation", options.segmentation,
                 "Source of objects: auto[:MODEL.yaml] (the default: motion and a neural network together, motion "
                 "alone where none can be loaded or memory.budget_mib has no room for it), motion, none (no "
                 "objects), mask files (KITTI MOTS PNG) as masks:LEFT_DIR[,RIGHT_DIR], a neural network alone as "
                 "onnx[:MODEL.yaml], or dds: masks that another process sends, see kinetrace masks")
      ->type_name("HOW");
  add_config_options(run, options.config);
  run.add_option("--out", options.out, "Run folder; made, or replaced if it is an earlier run's")
      ->type_name("DIR")
      ->required();
  run.add_option("--refine", options.refine,
                 "batch: refines the run as a whole after its end, see kinetrace refine; DIR is the refined run then, "
                 "DIR.online the one before. Takes 4000 features and waits for each "
                 "frame's own masks, unless --set says otherwise, and memory and time accordingly")
      ->type_name("HOW")
      ->check(CLI::IsMember({"batch"}));
  run.add_flag(
      "--images", options.images,
      "Also writes the rectified left images into the run folder, with --refine into DIR.online: the images of its "
      "COLMAP models");
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

#include "cli/command_line.hpp"

#include <array>
#include <map>
#include <string>

#include <CLI/CLI.hpp>

#include "cli/command_errors.hpp"
#include "cli/option_checks.hpp"

namespace kinetrace::app {
namespace {

struct Command {
  const char* name;
  const char* description;
  Action (*add)(CLI::App& command);
};

// In the order of --help. Also the source of completion, the manual page and suggestions.
constexpr std::array kCommands{
    Command{"run", "Reconstructs trajectories from a recording or a camera into a run folder", add_run},
    Command{"record", "Records a camera's synchronised raw images, without processing", add_record},
    Command{"calibrate", "Calibrates both cameras from images of a chessboard, a ChArUco board or a grid of AprilTags",
            add_calibrate},
    Command{"refine", "Refines a finished run: camera and objects from the whole recording at once", add_refine},
    Command{"doctor", "Checks cameras, timing, calibration, memory and DDS; prints a remedy for each failure",
            add_doctor},
    Command{"bench", "Times every stage on a recording, alone or against an earlier version; writes no run folder",
            add_bench},
    Command{"plan", "Prints the memory of each part against the budget", add_plan},
    Command{"config", "Prints the whole configuration as commented YAML", add_config},
    Command{"evaluate", "Compares a run with ground truth; writes evaluation.json into the run folder", add_evaluate},
    Command{"study", "Measures errors of the method over conditions", add_study},
    Command{"summary", "Prints the results of a run: the camera's path, and a table of objects", add_summary},
    Command{"figure", "Draws the result figure of a run as a PNG, 1600 pixels wide", add_figure},
    Command{"map", "Aligns a run with a GNSS or other reference; writes its trajectories in WGS84 and a map", add_map},
    Command{"keys", "Makes an authority, identities and permissions for DDS Security; never overwrites any", add_keys},
    Command{"monitor", "Shows the topics of a running Kinetrace: objects, health and rates; records them for ROS 2",
            add_monitor},
    Command{"masks", "Sends masks from files to a run with --segmentation dds; an example for networks elsewhere",
            add_masks},
    Command{"segment", "Runs a neural network on images: writes its masks, and draws them", add_segment},
    Command{"reference", "Prints this command line as a manual page or for bash", add_reference},
};

// Footer of the help of commands without a footer of their own.
constexpr const char* kFooter = R"(
Exit codes: 0 done, 1 a condition of --fail-if holds or a check of doctor failed, 64 wrong command line, 65 damaged or unusable recording,
calibration or truth, 66 input not found, 70 internal error, 73 run folder cannot be made, 74 reading or writing failed,
78 wrong configuration or memory budget too small; 128 + n when signal n ended a run early (the results so far are
written).)";

}  // namespace

Outcome<Action> parse_command_line(int argc, const char* const* argv) {
  CLI::App program(
      "Kinetrace: a stereo camera or recording in, metric 3-D trajectories of the camera and of every object out.",
      "kinetrace");
  program.set_version_flag("--version", std::string("kinetrace ") + KINETRACE_VERSION);
  program.require_subcommand(1);
  program.footer(kFooter);
  std::map<const CLI::App*, Action> actions;
  for (const Command& each : kCommands) {
    CLI::App& command = *program.add_subcommand(each.name, each.description);
    actions[&command] = each.add(command);
  }
  refuse_missing_values(program);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
      program.exit(error);
      return [] { return 0; };
    }
    return Unexpected(Failure{ExitCode::kUsage, command_error(program, error)});
  }
  return actions.at(program.get_subcommands().front());
}

}  // namespace kinetrace::app

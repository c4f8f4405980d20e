// The commands of the program. A command is one file, declared here, and one row of the table in command_line.cpp.
#pragma once

#include <functional>
#include <memory>

// NOLINTNEXTLINE(readability-identifier-naming): theirs.
namespace CLI {
class App;
}

namespace kinetrace::app {

/// The action of a parsed command line. Returns the exit code.
using Action = std::function<int()>;

/// For a command whose options are the fields of one struct: `add_options` binds them, `carry_out` receives them.
template <typename Options>
[[nodiscard]] Action bind_options(CLI::App& command, void (*add_options)(CLI::App&, Options&),
                                  int (*carry_out)(const Options&)) {
  const auto options = std::make_shared<Options>();
  add_options(command, *options);
  return [options, carry_out] { return carry_out(*options); };
}

// Each adds the options of its command and returns the command's action.

/// Processes a recording or a camera into a run folder.
[[nodiscard]] Action add_run(CLI::App& command);
/// Records raw images.
[[nodiscard]] Action add_record(CLI::App& command);
/// Calibrates from images of a target, by a program of its own.
[[nodiscard]] Action add_calibrate(CLI::App& command);
/// Refines a whole run, by a program of its own.
[[nodiscard]] Action add_refine(CLI::App& command);
/// Checks cameras, calibration and memory.
[[nodiscard]] Action add_doctor(CLI::App& command);
/// Times the stages on a recording.
[[nodiscard]] Action add_bench(CLI::App& command);
/// Prints the memory plan.
[[nodiscard]] Action add_plan(CLI::App& command);
/// Prints the configuration as commented YAML.
[[nodiscard]] Action add_config(CLI::App& command);
/// Compares a run with ground truth.
[[nodiscard]] Action add_evaluate(CLI::App& command);
/// Measures errors of an object's reconstruction by its size in the image and the number of frames.
[[nodiscard]] Action add_study(CLI::App& command);
/// Prints the results of a run.
[[nodiscard]] Action add_summary(CLI::App& command);
/// Draws the result figure of a run and, on request, every frame with its results.
[[nodiscard]] Action add_figure(CLI::App& command);
/// Aligns a run with a reference and writes its trajectories for maps, by a program of its own.
[[nodiscard]] Action add_map(CLI::App& command);
/// Makes keys, certificates and permissions for DDS Security.
[[nodiscard]] Action add_keys(CLI::App& command);
/// Shows what a running Kinetrace publishes, and records it.
[[nodiscard]] Action add_monitor(CLI::App& command);
/// Sends masks from files to a run that asks for them.
[[nodiscard]] Action add_masks(CLI::App& command);
/// Tries a neural network on images.
[[nodiscard]] Action add_segment(CLI::App& command);
/// Prints the command line as a manual page or as completion for a shell.
[[nodiscard]] Action add_reference(CLI::App& command);

}  // namespace kinetrace::app

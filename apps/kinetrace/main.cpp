// The command line of Kinetrace.
#include <exception>
#include <optional>
#include <string>
#include <variant>

#include "command_line.hpp"
#include "commands.hpp"
#include "exit_codes.hpp"
#include "messages.hpp"
#include "standard_files.hpp"

namespace kinetrace::app {
namespace {

struct Dispatch {
  int operator()(const RunOptions& options) const { return run_command(options); }
  int operator()(const RecordOptions& options) const { return record_command(options); }
  int operator()(const DoctorOptions& options) const { return doctor_command(options); }
  int operator()(const BenchOptions& options) const { return bench_command(options); }
  int operator()(const PlanOptions& options) const { return plan_command(options); }
  int operator()(const ConfigOptions& options) const { return config_command(options); }
  int operator()(const EvaluateOptions& options) const { return evaluate_command(options); }
  int operator()(const StudyOptions& options) const { return study_command(options); }
  int operator()(const FigureOptions& options) const { return figure_command(options); }
  int operator()(const KeysOptions& options) const { return keys_command(options); }
  int operator()(const MonitorOptions& options) const { return monitor_command(options); }
  int operator()(const SummaryOptions& options) const { return summary_command(options); }
  int operator()(const MaskOptions& options) const { return mask_command(options); }
  int operator()(const SegmentOptions& options) const { return segment_command(options); }
  int operator()(const NothingToDo& /*options*/) const { return 0; }
};

int carry_out(int argc, char** argv) {
  // The last resort: the library reports errors as values, but the system may refuse memory.
  try {
    const Outcome<Command> command = parse_command_line(argc, argv);
    return command ? std::visit(Dispatch{}, *command) : report(command.error());
  } catch (const std::exception& error) {
    return report({ExitCode::kInternal, error.what()});
  }
}

// Whatever a command printed: what is lost on the way out is no success.
int finish_output(int exit_code) {
  const std::optional<std::string> lost = output_failure();
  const int writing_failed = lost ? report({ExitCode::kIo, *lost}) : 0;
  return exit_code == 0 ? writing_failed : exit_code;
}

}  // namespace
}  // namespace kinetrace::app

int main(int argc, char** argv) {
  using namespace kinetrace::app;
  prepare_standard_files();
  return finish_output(carry_out(argc, argv));
}

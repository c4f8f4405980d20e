// kinetrace-refine: what `kinetrace refine` starts.
#include <exception>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "cli/command_errors.hpp"
#include "cli/messages.hpp"
#include "cli/standard_files.hpp"
#include "refine.hpp"

namespace kinetrace::batch {
namespace {

int carry_out(int argc, char** argv) {
  // The library reports errors as values, but allocations and other libraries may throw.
  try {
    CLI::App program("Refines a run as a whole; started by `kinetrace refine`.", app::kRefineCompanion.program);
    program.set_version_flag("--version", std::string("kinetrace-refine ") + KINETRACE_VERSION);
    app::RefineOptions options;
    app::add_refine_options(program, options);
    try {
      program.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      return error.get_exit_code() == 0 ? program.exit(error)
                                        : app::report({app::ExitCode::kUsage, app::command_error(program, error)});
    }
    return refine_command(options);
  } catch (const std::exception& error) {
    return app::report({app::ExitCode::kInternal, error.what()});
  }
}

}  // namespace
}  // namespace kinetrace::batch

int main(int argc, char** argv) {
  using namespace kinetrace::app;
  prepare_standard_files();
  const int exit_code = kinetrace::batch::carry_out(argc, argv);
  const std::optional<std::string> lost = output_failure();
  const int writing_failed = lost ? report({ExitCode::kIo, *lost}) : 0;
  return exit_code == 0 ? writing_failed : exit_code;
}

// The command line of Kinetrace.
#include <exception>
#include <optional>
#include <string>

#include "cli/command_line.hpp"
#include "cli/exit_codes.hpp"
#include "cli/messages.hpp"
#include "cli/standard_files.hpp"

namespace kinetrace::app {
namespace {

int carry_out(int argc, char** argv) {
  // Last resort: the library reports errors as values, but an allocation may fail.
  try {
    const Outcome<Action> action = parse_command_line(argc, argv);
    return action ? (*action)() : report(action.error());
  } catch (const std::exception& error) {
    return report({ExitCode::kInternal, error.what()});
  }
}

// Lost output turns success into failure.
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

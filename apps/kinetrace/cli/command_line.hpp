// From the words of the command line to what the program is to do.
#pragma once

#include "cli/commands.hpp"
#include "cli/failure.hpp"

namespace kinetrace::app {

/// Reads the command line. Help and the version are printed at once; then nothing is left to do. Failures: kUsage.
[[nodiscard]] Outcome<Action> parse_command_line(int argc, const char* const* argv);

}  // namespace kinetrace::app

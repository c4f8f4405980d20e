// Parses the command line into the action to run.
#pragma once

#include "cli/commands.hpp"
#include "cli/failure.hpp"

namespace kinetrace::app {

/// Reads the command line. Help and the version are printed at once; the action is then empty. Failures: kUsage.
[[nodiscard]] Outcome<Action> parse_command_line(int argc, const char* const* argv);

}  // namespace kinetrace::app

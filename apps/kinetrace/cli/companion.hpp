// Commands that a program of their own carries out, beside this one.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::app {

struct Companion {
  const char* program;  ///< Beside this one.
  const char* package;  ///< That brings it.
  const char* doing;    ///< "calibrating": what needs it.
};

/// An error if the program is not there.
[[nodiscard]] Status check(const Companion& companion);
/// Becomes that program, with these arguments. Returns only if it cannot be started: the exit code of the
/// failure, which has been reported.
int become(const Companion& companion, std::vector<std::string> arguments);

/// What is left to do for a command whose options are checked here, where their help is, and then passed on as they
/// were given. `options` are what the command's options are bound to.
[[nodiscard]] Action pass_on(CLI::App& command, std::shared_ptr<void> options, const Companion& companion);

}  // namespace kinetrace::app

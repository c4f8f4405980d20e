// Commands implemented by a separate program beside this one.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::app {

struct Companion {
  const char* program;  ///< Beside this one.
  const char* package;  ///< Package of the program.
  const char* doing;    ///< Purpose: "calibrating".
};

/// An error if the program is not there.
[[nodiscard]] Status check(const Companion& companion);
/// Replaces this process by the program (exec) with these arguments. Returns only on failure, which has been reported:
/// the exit code.
int exec_companion(const Companion& companion, std::vector<std::string> arguments);

/// The action of a command whose options are checked here, where their help is, and then passed on unchanged. The
/// command's options are bound to `options`.
[[nodiscard]] Action forward_options(CLI::App& command, std::shared_ptr<void> options, const Companion& companion);

}  // namespace kinetrace::app

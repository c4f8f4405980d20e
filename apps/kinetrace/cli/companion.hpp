// Programs that a command starts in its place: what no board needs to carry.
#pragma once

#include "cli/commands.hpp"

namespace kinetrace::app {

struct Companion {
  const char* program;  ///< Beside this one.
  const char* package;  ///< Which brings it.
  const char* purpose;  ///< Begins "; ... needs the package": what cannot be done without.
};

/// The action of a command that has all options of the companion, which are checked here, where their help is, and then
/// passed on. Returns only if it cannot be started: kNoInput.
[[nodiscard]] Action become_companion(CLI::App& command, const Companion& companion);

}  // namespace kinetrace::app

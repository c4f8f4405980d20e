// Manual page and shell completion, made from the command line itself.
#pragma once

#include <string>

// NOLINTNEXTLINE(readability-identifier-naming): theirs.
namespace CLI {
class App;
}

namespace kinetrace::app {

/// A page for man(1), in the macros of groff_man(7).
[[nodiscard]] std::string manual_page(const CLI::App& program);

/// A script for bash's complete: commands, their options, and the values of options that know theirs; else files.
[[nodiscard]] std::string bash_completion(const CLI::App& program);

}  // namespace kinetrace::app

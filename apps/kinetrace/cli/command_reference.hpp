// Manual page and shell completion, made from the command line itself.
#pragma once

#include <map>
#include <string>
#include <vector>

// NOLINTNEXTLINE(readability-identifier-naming): theirs.
namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace kinetrace::app {

/// A page for man(1), in the macros of groff_man(7).
[[nodiscard]] std::string manual_page(const CLI::App& program);

/// Values that an option can be given besides those it is checked against, by its name ("--dataset", "SCENE"). What
/// ends with a colon goes on.
using ValueHints = std::map<std::string, std::vector<std::string>>;

/// A script for bash's complete: commands, their options, and the values of options that know theirs; else files.
[[nodiscard]] std::string bash_completion(const CLI::App& program, const ValueHints& hints);

/// Commands below `command`; groups of options, which CLI11 keeps as commands without a name, are not among them.
[[nodiscard]] std::vector<const CLI::App*> commands_of(const CLI::App& command);
/// Those of its groups, too.
[[nodiscard]] std::vector<const CLI::Option*> options_of(const CLI::App& command);

}  // namespace kinetrace::app

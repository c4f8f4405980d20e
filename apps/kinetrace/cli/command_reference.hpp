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

/// Completions of an option beyond its checked values, by the option's name ("--dataset", "SCENE"), with its command
/// before it where commands differ ("map --reference"). A value that ends with a colon is a prefix.
using ValueHints = std::map<std::string, std::vector<std::string>>;

/// A script for bash's complete: commands, their options, and the values of options that list them; else files.
[[nodiscard]] std::string bash_completion(const CLI::App& program, const ValueHints& hints);

/// Subcommands of `command`, without groups of options, which CLI11 represents as commands without a name.
[[nodiscard]] std::vector<const CLI::App*> commands_of(const CLI::App& command);
/// Including the options of its groups.
[[nodiscard]] std::vector<const CLI::Option*> options_of(const CLI::App& command);

}  // namespace kinetrace::app

#include "cli/command_errors.hpp"

#include <deque>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "cli/command_reference.hpp"
#include "kinetrace/core/nearest_name.hpp"

namespace kinetrace::app {
namespace {

using Names = std::deque<std::string>;  // A deque, so that elements do not move.

std::string nearest(std::string_view word, const Names& names) {
  return did_you_mean(word, std::vector<std::string_view>(names.begin(), names.end()));
}

std::string unknown_option(const std::string& argument, const CLI::App& command, const std::string& name) {
  const std::string option = argument.substr(0, argument.find('='));
  Names names;
  for (const CLI::Option* known : options_of(command)) {
    for (const std::string& each : known->get_lnames()) {
      names.push_back("--" + each);
    }
  }
  const std::string meant = nearest(option, names);
  return option + ": no such option" + (meant.empty() ? " of " + name + "; see " + name + " --help" : meant);
}

std::string unknown_word(const std::string& word, const CLI::App& command, const std::string& name) {
  Names names;
  for (const CLI::App* each : commands_of(command)) {
    names.push_back(each->get_name());
  }
  if (names.empty()) {
    return "\"" + word + "\" is one argument too many; see " + name + " --help";
  }
  const std::string meant = nearest(word, names);
  return word + ": no such command" + (meant.empty() ? "; see " + name + " --help" : meant);
}

// The option of one value that was given several; null if the mismatch is another.
const CLI::Option* repeated_option(const CLI::App& command) {
  for (const CLI::Option* option : options_of(command)) {
    if (option->count() > 1 && option->get_items_expected_max() == 1) {
      return option;
    }
  }
  return nullptr;
}

// Searches the innermost recognised command: the words before it were valid. A value that is refused comes first: it
// may be an option taken for a value, which leaves words over.
std::string explained(const CLI::App& command, const std::string& name, const CLI::ParseError& error) {
  const bool is_refused_value = dynamic_cast<const CLI::ValidationError*>(&error) != nullptr;
  const std::vector<std::string> remaining = command.remaining();
  if (!remaining.empty() && !is_refused_value) {
    const std::string& word = remaining.front();
    return word.size() > 1 && word.front() == '-' ? unknown_option(word, command, name)
                                                  : unknown_word(word, command, name);
  }
  for (const CLI::App* inner : command.get_subcommands()) {
    if (!inner->get_name().empty()) {
      return explained(*inner, name + " " + inner->get_name(), error);
    }
  }
  const bool is_mismatch = dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr;
  if (const CLI::Option* option = is_mismatch ? repeated_option(command) : nullptr) {
    return option->get_name() + " is given " + std::to_string(option->count()) + " times; keep one";
  }
  return std::string(error.what()) + "; see " + name + " --help";
}

}  // namespace

std::string command_error(const CLI::App& program, const CLI::ParseError& error) {
  return explained(program, program.get_name(), error);
}

}  // namespace kinetrace::app

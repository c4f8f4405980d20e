#include "cli/companion.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <unistd.h>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "cli/messages.hpp"
#include "cli/program_folder.hpp"

namespace kinetrace::app {
namespace {

/// A flag as it was given in the end: --quiet --quiet=false is none. Flags declared as "!--no-x" set their variable to
/// false.
std::string given_flag(const CLI::Option& flag) {
  const bool is_negated = !flag.get_fnames().empty();
  return flag.get_name() + (flag.as<bool>() != is_negated ? "=true" : "=false");
}

/// The given options, each in one word, so that no value is taken for an option.
void append_given(const CLI::App& command, std::vector<std::string>& options, std::vector<std::string>& positionals) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0 || option->get_name() == "--help") {
      continue;
    }
    if (option->get_expected_max() == 0) {
      options.push_back(given_flag(*option));
      continue;
    }
    for (const std::string& value : option->results()) {
      if (option->get_positional()) {
        positionals.push_back(value);
      } else {
        options.push_back(option->get_name() + "=" + value);
      }
    }
  }
  for (const CLI::App* group : command.get_subcommands([](const CLI::App*) { return true; })) {
    append_given(*group, options, positionals);
  }
}

/// The command line as it was given.
std::vector<std::string> given(const CLI::App& command) {
  std::vector<std::string> words;
  std::vector<std::string> positionals;
  append_given(command, words, positionals);
  if (!positionals.empty()) {
    words.emplace_back("--");
    words.insert(words.end(), positionals.begin(), positionals.end());
  }
  return words;
}

}  // namespace

Status check(const Companion& companion) {
  const std::filesystem::path program = program_folder() / companion.program;
  if (::access(program.c_str(), X_OK) == 0) {
    return {};
  }
  return fail(ErrorCode::kNotFound, program.string() + ": " + std::strerror(errno) + "; " + companion.doing +
                                        " needs the package " + companion.package +
                                        ", or a whole build of a checkout: cmake --build build/release");
}

int exec_companion(const Companion& companion, std::vector<std::string> arguments) {
  const std::filesystem::path program = program_folder() / companion.program;
  arguments.insert(arguments.begin(), program.string());
  std::vector<char*> pointers;
  pointers.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) {
    pointers.push_back(argument.data());
  }
  pointers.push_back(nullptr);
  std::fflush(nullptr);
  ::execv(program.c_str(), pointers.data());
  const int why = errno;
  const Status missing = check(companion);
  return report(missing ? Failure{ExitCode::kNoInput, program.string() + ": " + std::strerror(why)}
                        : to_failure(missing.error()));
}

Action forward_options(CLI::App& command, std::shared_ptr<void> options, const Companion& companion) {
  const auto arguments = std::make_shared<std::vector<std::string>>();
  command.callback([&command, options = std::move(options), arguments] { *arguments = given(command); });
  return [arguments, companion] { return exec_companion(companion, *arguments); };
}

}  // namespace kinetrace::app

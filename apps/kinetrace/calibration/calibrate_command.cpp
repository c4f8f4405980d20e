// Starts the program that calibrates: a board that only runs does not carry what estimation takes.
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <unistd.h>
#include <vector>

#include <CLI/CLI.hpp>

#include "calibration/calibrate_options.hpp"
#include "cli/commands.hpp"
#include "cli/messages.hpp"
#include "cli/program_folder.hpp"

namespace kinetrace::app {
namespace {

// The options that were given, as they were given.
void append_given(const CLI::App& command, std::vector<std::string>& arguments) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0 || option->get_name() == "--help") {
      continue;
    }
    if (option->get_expected_max() == 0) {
      arguments.push_back(option->get_name());
      continue;
    }
    for (const std::string& value : option->results()) {
      arguments.push_back(option->get_name());
      arguments.push_back(value);
    }
  }
  for (const CLI::App* group : command.get_subcommands([](const CLI::App*) { return true; })) {
    append_given(*group, arguments);
  }
}

// Returns only if it cannot be started.
int become_calibrate(std::vector<std::string> arguments) {
  const std::filesystem::path program = program_folder() / kCalibrateProgram;
  arguments.insert(arguments.begin(), program.string());
  std::vector<char*> pointers;
  for (std::string& argument : arguments) {
    pointers.push_back(argument.data());
  }
  pointers.push_back(nullptr);
  ::execv(program.c_str(), pointers.data());
  return report({ExitCode::kNoInput, program.string() + ": " + std::strerror(errno) +
                                         "; calibrating needs the package " + kCalibratePackage});
}

}  // namespace

Action add_calibrate(CLI::App& command) {
  const auto options = std::make_shared<CalibrateOptions>();
  const auto arguments = std::make_shared<std::vector<std::string>>();
  add_calibrate_options(command, *options);
  // Its options are checked here, where their help is, and then passed on.
  command.callback([&command, options, arguments] { append_given(command, *arguments); });
  return [arguments] { return become_calibrate(*arguments); };
}

}  // namespace kinetrace::app

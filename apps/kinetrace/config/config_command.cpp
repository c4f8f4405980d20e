#include <cstdio>
#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/messages.hpp"
#include "cli/shared_options.hpp"
#include "config/app_config.hpp"
#include "config/config_file.hpp"

namespace kinetrace::app {

namespace {

struct ConfigOptions {
  ConfigSource config;
};

int config_command(const ConfigOptions& options) {
  Result<AppConfig> config = load_config(options.config);
  if (!config) {
    return report(to_failure(config.error()));
  }
  // What is printed may become a file in any folder, to which its paths would be relative.
  for (std::string* path : config->paths()) {
    *path = path->empty() ? *path : std::filesystem::absolute(*path).lexically_normal().string();
  }
  std::printf(
      "# Kinetrace configuration: every key with its value. Keys left out keep their default; paths are relative to "
      "this file.\n%s",
      to_yaml(fields_of(*config)).c_str());
  return 0;
}

void add_options(CLI::App& config, ConfigOptions& options) {
  add_config_options(config, options.config);
}

}  // namespace

Action add_config(CLI::App& command) {
  return bind_options(command, add_options, config_command);
}

}  // namespace kinetrace::app

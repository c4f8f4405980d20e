#include <cstdio>

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
  std::printf("# Kinetrace configuration: every key with its value. Keys left out keep their default.\n%s",
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

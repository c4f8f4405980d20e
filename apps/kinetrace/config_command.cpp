#include <cstdio>

#include "app_config.hpp"
#include "commands.hpp"
#include "config_file.hpp"
#include "messages.hpp"

namespace kinetrace::app {

int config_command(const ConfigOptions& options) {
  Result<AppConfig> config = load_config(options.config);
  if (!config) {
    return report(to_failure(config.error()));
  }
  std::printf("# Kinetrace configuration: every key with its value. Keys left out keep their default.\n%s",
              to_yaml(fields_of(*config)).c_str());
  return 0;
}

}  // namespace kinetrace::app

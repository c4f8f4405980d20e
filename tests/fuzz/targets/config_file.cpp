// A configuration file; an accepted one is written and read back.
#include "config/config_file.hpp"

#include "config/app_config.hpp"
#include "fuzz_target.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  // The table of fields is built once: it takes longer than the tested call.
  static app::AppConfig config;
  static const app::ConfigFields fields = fields_of(config);
  config = {};
  if (app::read_config_text("config.yaml", input, fields)) {
    const std::string yaml = app::to_yaml(fields);
    require(app::read_config_text("again.yaml", yaml, fields).has_value() && app::to_yaml(fields) == yaml);
    static_cast<void>(app::to_json(fields));
  }
}

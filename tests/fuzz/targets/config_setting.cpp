// Arguments of --set, one a line.
#include "config/app_config.hpp"
#include "config/config_file.hpp"
#include "fuzz_target.hpp"
#include "util/text_file.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  // The table of fields is built once: it takes longer than the tested call.
  static app::AppConfig config;
  static const app::ConfigFields fields = fields_of(config);
  config = {};
  for (const std::string_view line : hal::content_lines(input)) {
    static_cast<void>(app::apply_setting(line, fields));
  }
}

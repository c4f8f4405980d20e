#include "dds/dds_link.hpp"

#include "cli/messages.hpp"
#include "dds/publish_config_file.hpp"

namespace kinetrace::app {

Result<publishing::PublishConfig> network_config(const NetworkOptions& options) {
  publishing::PublishConfig config;
  if (!options.file.empty()) {
    Result<publishing::PublishConfig> read = load_publish_config(options.file);
    if (!read) {
      return read;
    }
    config = std::move(*read);
  }
  config.domain = options.domain.value_or(config.domain);
  config.interface = options.interface.empty() ? config.interface : options.interface;
  config.device = options.device.empty() ? config.device : options.device;
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  return config;
}

void serve(publishing::Link& link) {
  constexpr std::int64_t kAtMost_ns = 100'000'000;
  link.supervise(steady_time_ns());
  while (const std::optional<std::string> notice = link.take_notice()) {
    print_warning(*notice);
  }
  link.wait(kAtMost_ns);
}

}  // namespace kinetrace::app

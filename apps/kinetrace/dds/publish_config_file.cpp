#include "dds/publish_config_file.hpp"

#include <array>

#include "config/config_fields.hpp"
#include "config/config_file.hpp"

namespace kinetrace::app {

Result<publishing::PublishConfig> load_publish_config(const std::filesystem::path& path) {
  publishing::PublishConfig config;
  const ConfigFileKind kind{.missing = "no such file for publishing; copy one of config/dds",
                            .unfit = "not a file for publishing (a YAML text below 1 MiB); copy one of config/dds",
                            .empty = "is empty; copy one of config/dds",
                            .key_list = "the files in config/dds show the keys"};
  if (const Status read = read_config_file(path, fields_of(config), kind); !read) {
    return Unexpected(read.error());
  }
  publishing::SecurityConfig& security = config.security;
  resolve_paths(path,
                std::array{&config.xml, &security.identity_ca, &security.certificate, &security.private_key,
                           &security.permissions_ca, &security.governance, &security.permissions, &security.plugins});
  if (const Status valid = config.validate(); !valid) {
    return fail(valid.error().code, path.string() + ": " + valid.error().message);
  }
  return config;
}

}  // namespace kinetrace::app

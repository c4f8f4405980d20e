// Checks the files of DDS Security before the library, whose errors are late and terse.
#pragma once

#include <cstdint>
#include <string>

#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/publish_config.hpp"

namespace kinetrace::publishing {

/// The folder with Cyclone's security libraries: as configured, else beside the DDS library as distributions install
/// it. Empty if none is found.
[[nodiscard]] std::string security_plugin_folder(const SecurityConfig& config);

/// Checks that the required files exist and parse, certificates are valid now and signed by the authority, the key
/// belongs to the certificate, and governance and permissions are signed. `now_s` is the system clock (Unix). Errors:
/// kNotFound, kInvalidConfig.
[[nodiscard]] Status check_security_files(const SecurityConfig& config, std::int64_t now_s);

}  // namespace kinetrace::publishing

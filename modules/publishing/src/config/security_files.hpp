// The files of DDS Security, checked before the library sees them: it would say little, and late.
#pragma once

#include <cstdint>
#include <string>

#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/publish_config.hpp"

namespace kinetrace::publishing {

/// The folder with Cyclone's security libraries: as configured, else beside the DDS library as distributions install
/// it. Empty where none is found.
[[nodiscard]] std::string security_plugin_folder(const SecurityConfig& config);

/// Whether what is required is there and fits together: files exist and parse, certificates are valid now and signed by
/// the authority, the key belongs to the certificate, governance and permissions are signed. `now_s` is the system
/// clock (Unix). Errors: kNotFound, kInvalidConfig.
[[nodiscard]] Status check_security_files(const SecurityConfig& config, std::int64_t now_s);

}  // namespace kinetrace::publishing

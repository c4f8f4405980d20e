// Configuration of Cyclone DDS.
#pragma once

#include <string>
#include <string_view>

#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/publish_config.hpp"

namespace kinetrace::publishing {

/// One interface, small buffers, no shared memory (which aborts the process where its daemon is missing), and security
/// if required. Passed to dds_create_domain, it prevents the library from reading CYCLONEDDS_URI.
[[nodiscard]] std::string domain_xml(const PublishConfig& config, bool interface_has_multicast);

/// Reads the user's configuration and refuses settings that would silently have no effect: another domain's Id, shared
/// memory, security (which has keys of its own). Errors: kNotFound, kIo, kInvalidConfig.
[[nodiscard]] Result<std::string> read_own_xml(const PublishConfig& config);

}  // namespace kinetrace::publishing

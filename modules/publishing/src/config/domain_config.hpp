// The configuration that Cyclone DDS is started with.
#pragma once

#include <string>
#include <string_view>

#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/publish_config.hpp"

namespace kinetrace::publishing {

/// One interface, small buffers, no shared memory (which aborts the process where its daemon is missing), and security
/// if required. Given to dds_create_domain, it keeps the library from looking at CYCLONEDDS_URI.
[[nodiscard]] std::string domain_xml(const PublishConfig& config, bool interface_has_multicast);

/// The user's own configuration, checked for what would silently not be what it says: another domain's, shared memory,
/// security (which has keys of its own). Errors: kNotFound, kIo, kInvalidConfig.
[[nodiscard]] Result<std::string> read_own_xml(const PublishConfig& config);

}  // namespace kinetrace::publishing

// The configuration file of publishing.
#pragma once

#include <filesystem>

#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/publish_config.hpp"

namespace kinetrace::app {

/// Reads and checks the file; relative paths in it are resolved against its folder. See config/dds for commented
/// examples. Errors, with file and line or key: kNotFound, kIo, kInvalidConfig.
[[nodiscard]] Result<publishing::PublishConfig> load_publish_config(const std::filesystem::path& path);

}  // namespace kinetrace::app

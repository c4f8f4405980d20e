// The file that says what is published, and how.
#pragma once

#include <filesystem>

#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/publish_config.hpp"

namespace kinetrace::app {

/// Reads and checks it; paths in it become relative to the working directory. See config/dds for commented examples.
/// Errors, with file and line or key: kNotFound, kIo, kInvalidConfig.
[[nodiscard]] Result<publishing::PublishConfig> load_publish_config(const std::filesystem::path& path);

}  // namespace kinetrace::app

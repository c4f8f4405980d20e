// The YAML file beside a neural network.
#pragma once

#include <filesystem>

#include "kinetrace/core/result.hpp"
#include "kinetrace/neural/instance_network.hpp"
#include "kinetrace/neural/model.hpp"

namespace kinetrace::app {

/// Reads what describes a network; file names in it are relative to it. Errors, with file and line: kNotFound (empty
/// `path`: the network that comes with Kinetrace is not installed), kIo, kInvalidConfig.
[[nodiscard]] Result<neural::ModelConfig> load_model(const std::filesystem::path& path);

}  // namespace kinetrace::app

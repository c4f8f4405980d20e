// The YAML file that describes a neural network.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "kinetrace/core/result.hpp"
#include "kinetrace/neural/instance_network.hpp"
#include "kinetrace/neural/model.hpp"

namespace kinetrace::app {

/// Reads the description of a network; file names in it are relative to it. Errors, with file and line: kNotFound
/// (empty `path`: the bundled network is not installed), kIo, kInvalidConfig.
[[nodiscard]] Result<neural::ModelConfig> load_model(const std::filesystem::path& path);

/// Warns if a network trained on rendered pictures alone is used on others; else none. `pictures`: a file or folder;
/// empty for a camera.
[[nodiscard]] std::optional<std::string> model_caution(const neural::ModelConfig& model,
                                                       const std::filesystem::path& pictures);

}  // namespace kinetrace::app

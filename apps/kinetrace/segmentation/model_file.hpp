// The YAML file beside a neural network.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "kinetrace/core/result.hpp"
#include "kinetrace/neural/instance_network.hpp"
#include "kinetrace/neural/model.hpp"

namespace kinetrace::app {

/// Reads what describes a network; file names in it are relative to it. Errors, with file and line: kNotFound (empty
/// `path`: the network that comes with Kinetrace is not installed), kIo, kInvalidConfig.
[[nodiscard]] Result<neural::ModelConfig> load_model(const std::filesystem::path& path);

/// What to tell whoever uses this network on these pictures, a file or folder or, of a camera, nothing: one that knows
/// rendered pictures only is not for others. None if there is nothing to tell.
[[nodiscard]] std::optional<std::string> model_caution(const neural::ModelConfig& model,
                                                       const std::filesystem::path& pictures);

}  // namespace kinetrace::app

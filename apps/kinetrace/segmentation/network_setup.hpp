// From the configuration to a neural network that is ready.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "config/app_config.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "segmentation/network_thread.hpp"

namespace kinetrace::app {

/// Null unless segmentation.mode is onnx. `waits`: for a recording, whose frames wait for their masks. Errors: those of
/// load_model and NetworkThread::create.
[[nodiscard]] Result<std::unique_ptr<NetworkThread>> start_network(const AppConfig& config,
                                                                   const StereoGeometry& geometry, bool waits);

/// As model_caution, of the configured network; none unless segmentation.mode is onnx.
[[nodiscard]] std::optional<std::string> network_caution(const AppConfig& config,
                                                         const std::filesystem::path& pictures);

}  // namespace kinetrace::app

// Check of the neural network by `kinetrace doctor`.
#pragma once

#include <string>

#include "config/app_config.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "segmentation/network_thread.hpp"

namespace kinetrace::app {

struct ModelFinding {
  bool holds = true;
  std::string detail;
};

/// Times the started network on pictures of this size, for a camera of `rate_hz`. A network slower than the camera
/// fails the check, unless it is optional, as for segmentation.mode auto.
[[nodiscard]] ModelFinding examine_model(const AppConfig& config, NetworkThread& network,
                                         const StereoGeometry& geometry, double rate_hz);

}  // namespace kinetrace::app

// What doctor says of the neural network.
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

/// Times the configured network, which has been started and waits, on pictures of this size, for a camera of `rate_hz`.
/// One that is late does not hold, unless it only helps, as for segmentation.mode auto.
[[nodiscard]] ModelFinding examine_model(const AppConfig& config, NetworkThread& network,
                                         const StereoGeometry& geometry, double rate_hz);

}  // namespace kinetrace::app

// What doctor says of the neural network.
#pragma once

#include <string>

#include "config/app_config.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::app {

struct ModelFinding {
  bool holds = true;
  std::string detail;
};

/// Loads the configured network and times it on pictures of this size, for a camera of `rate_hz`.
[[nodiscard]] ModelFinding examine_model(const AppConfig& config, const StereoGeometry& geometry, double rate_hz);

}  // namespace kinetrace::app

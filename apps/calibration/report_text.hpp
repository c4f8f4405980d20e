// Common parts of both calibration reports.
#pragma once

#include <numbers>

#include "cli/formatted.hpp"

namespace kinetrace::calibration {

using app::formatted;

inline constexpr double kDegrees = 180.0 / std::numbers::pi;

}  // namespace kinetrace::calibration

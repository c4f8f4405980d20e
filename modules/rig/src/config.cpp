#include "kinetrace/rig/config.hpp"

#include "kinetrace/core/config_check.hpp"

namespace kinetrace::rig {

Status RefineConfig::validate() const {
  return first_failure({
      check_range("calibration.max_points", max_points, 40, 10'000),
      check_range("calibration.prior_sigma_deg", prior_sigma_deg, 0.01, 5.0),
      check_range("calibration.bias_px", bias_px, 0.0, 5.0),
  });
}

}  // namespace kinetrace::rig

#include "kinetrace/trajectory/trajectory_config.hpp"

#include "kinetrace/core/config_check.hpp"

namespace kinetrace::trajectory {

Status TrajectoryConfig::validate() const {
  return first_failure({
      check_range("trajectory.velocity_window_s", velocity_window_s, 0.01, 1.0),
      check_range("trajectory.min_moving_speed_mps", min_moving_speed_mps, 0.0, 100.0),
      check_range("trajectory.moving_significance", moving_significance, 0.1, 100.0),
      check_range("trajectory.acceleration_mps2", motion.acceleration_mps2, 0.01, 1000.0),
      check_range("trajectory.vertical_acceleration_mps2", motion.vertical_acceleration_mps2, 0.01, 1000.0),
      check_range("trajectory.vertical_speed_mps", motion.vertical_speed_mps, 0.01, 1000.0),
      check_range("trajectory.turn_radps2", motion.turn_radps2, 0.001, 1000.0),
      check_range("trajectory.tilt_radps2", motion.tilt_radps2, 0.001, 1000.0),
      check_range("trajectory.stereo_sigma_px", stereo_sigma_px, 0.01, 100.0),
      check_range("trajectory.surface_sigma_m", surface_sigma_m, 0.0, 10.0),
  });
}

}  // namespace kinetrace::trajectory

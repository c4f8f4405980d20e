#include "kinetrace/trajectory/trajectory_config.hpp"

#include <string>

namespace kinetrace::trajectory {
namespace {

/// NaN is out of every range.
bool inside(double value, double low, double high) {
  return value >= low && value <= high;
}

Status out_of_range(const std::string& key, const std::string& range, const std::string& value) {
  return fail(ErrorCode::kInvalidConfig, "trajectory." + key + " must be in " + range + ", got " + value);
}

}  // namespace

Status TrajectoryConfig::validate() const {
  if (velocity_window_frames < 1 || velocity_window_frames > 10) {
    return out_of_range("velocity_window_frames", "[1, 10]", std::to_string(velocity_window_frames));
  }
  if (!inside(min_moving_speed_mps, 0.0, 100.0)) {
    return out_of_range("min_moving_speed_mps", "[0, 100]", std::to_string(min_moving_speed_mps));
  }
  if (!inside(moving_significance, 0.1, 100.0)) {
    return out_of_range("moving_significance", "[0.1, 100]", std::to_string(moving_significance));
  }
  if (!inside(max_acceleration_mps2, 0.01, 1000.0)) {
    return out_of_range("max_acceleration_mps2", "[0.01, 1000]", std::to_string(max_acceleration_mps2));
  }
  if (!inside(stereo_sigma_px, 0.01, 100.0)) {
    return out_of_range("stereo_sigma_px", "[0.01, 100]", std::to_string(stereo_sigma_px));
  }
  if (!inside(surface_sigma_m, 0.0, 10.0)) {
    return out_of_range("surface_sigma_m", "[0, 10]", std::to_string(surface_sigma_m));
  }
  if (!inside(smoothing_acceleration_mps2, 0.001, 1e6)) {
    return out_of_range("smoothing_acceleration_mps2", "[0.001, 1e6]", std::to_string(smoothing_acceleration_mps2));
  }
  if (!inside(smoothing_turn_radps2, 0.001, 1e6)) {
    return out_of_range("smoothing_turn_radps2", "[0.001, 1e6]", std::to_string(smoothing_turn_radps2));
  }
  return {};
}

}  // namespace kinetrace::trajectory

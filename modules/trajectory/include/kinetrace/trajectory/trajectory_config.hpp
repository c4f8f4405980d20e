// Settings of trajectories: smoothing, moving or not.
#pragma once

#include <string>

#include "kinetrace/core/body_velocity.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/trajectory/size_table.hpp"

namespace kinetrace::trajectory {

struct KINETRACE_API TrajectoryConfig {
  double velocity_window_s = 0.5;     ///< Velocity is fitted over this time before and after.
  double min_moving_speed_mps = 0.5;  ///< Slower objects are not called moving, whatever the significance.
  double moving_significance = 4.0;   ///< Speed over its standard deviation to become moving; half of it to stop.
  MotionPrior motion;                 ///< Of predictions and of smoothing.
  double stereo_sigma_px = 0.5;       ///< Standard deviation of a stereo position's image coordinates.
  double surface_sigma_m = 0.25;      ///< Drift of the visible part's centre over a stereo-only object.
  std::string sizes;                  ///< File of the size priors; empty: the table below.
  SizeTable size_table;               ///< Content of that file.

  [[nodiscard]] Status validate() const;
};

}  // namespace kinetrace::trajectory

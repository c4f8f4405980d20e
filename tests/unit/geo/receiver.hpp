// Paths with exact truth, and a receiver that measures them.
#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "kinetrace/geo/alignment.hpp"

namespace kinetrace::geo::test {

/// Camera poses with 10 Hz; `speed_mps` along a curve whose heading (rad, to the right) and pitch (rad, upwards) are
/// functions of the distance. The camera looks along the path.
struct PathShape {
  double length_m = 300.0;
  double speed_mps = 10.0;
  std::function<double(double)> heading_rad = [](double) { return 0.0; };
  std::function<double(double)> pitch_rad = [](double) { return 0.0; };
};
[[nodiscard]] std::vector<PathPose> drive(const PathShape& shape);

/// A drive round some blocks: right and left turns, 300 m.
[[nodiscard]] PathShape town();
/// A flight: turns, climbs and descents.
[[nodiscard]] PathShape flight();

/// True pose of the world, and the receiver's errors.
struct Receiver {
  Se3 T_map_world;
  Eigen::Vector3d lever_arm_m = Eigen::Vector3d::Zero();
  double time_offset_s = 0.0;  ///< Camera's clock minus the receiver's.
  double rate_hz = 10.0;
  double noise_m = 1.5;      ///< In each direction.
  double correlation = 0.0;  ///< Between neighbouring fixes.
  double outlier_share = 0.0;
  double outlier_m = 30.0;
};

[[nodiscard]] std::vector<Fix> receive(const std::vector<PathPose>& path, const Receiver& receiver,
                                       std::mt19937& random);

/// Any heading, and a tilt of the first camera of at most `tilt_rad`.
[[nodiscard]] Se3 any_placement(std::mt19937& random, double tilt_rad);

}  // namespace kinetrace::geo::test

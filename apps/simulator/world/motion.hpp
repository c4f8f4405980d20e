// Paths and speeds of vehicles and people.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "world/scene.hpp"

namespace kinetrace::simulator {

/// A smooth curve on the ground: a uniform cubic B-spline, whose continuous curvature means steering without jerks. It
/// begins at the first and ends at the last of the given points and passes near the others.
class GroundPath {
 public:
  /// Points are (x, z) in the scene frame; at least two.
  explicit GroundPath(std::vector<Eigen::Vector2d> points);

  [[nodiscard]] double length_m() const noexcept { return arc_lengths_.back(); }
  /// Pose at a distance along the path, x along the tangent; straight on beyond both ends.
  [[nodiscard]] Se3 pose_at(double distance_m) const;

 private:
  [[nodiscard]] Eigen::Vector2d point_at(double parameter) const;

  std::vector<Eigen::Vector2d> points_;
  std::vector<Eigen::Vector2d> samples_;
  std::vector<double> arc_lengths_;
};

/// Speed over time, smooth between knots and constant beyond them; its integral is the distance.
class SpeedProfile {
 public:
  struct Knot {
    double time_s = 0.0;
    double speed_mps = 0.0;
  };
  explicit SpeedProfile(std::vector<Knot> knots);
  [[nodiscard]] double distance_m(double time_s) const;
  /// The speed at every moment times `factor`.
  [[nodiscard]] SpeedProfile scaled(double factor) const;

 private:
  [[nodiscard]] double distance_since(const Knot& from, const Knot& to, double time_s) const;
  std::vector<Knot> knots_;
};

/// Motion along the path, from `start_m` at time zero.
[[nodiscard]] Trajectory drive(GroundPath path, SpeedProfile speed, double start_m = 0.0);
/// At rest on the ground at (x, z), turned by `heading_rad` from +x towards -z.
[[nodiscard]] Trajectory parked(double x_m, double z_m, double heading_rad);

/// The same, `height_m` above the scene's ground.
[[nodiscard]] Trajectory raised(Trajectory trajectory, double height_m);

/// A sum of slow sines in all six degrees of freedom: rotation amplitudes in radians, translation in metres.
struct Sway {
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();
  double slowest_hz = 0.3;
  double fastest_hz = 2.0;
  std::uint32_t seed = 0;
};
[[nodiscard]] Se3 sway_at(const Sway& sway, double time_s);

/// A camera that looks along a vehicle's x axis from `height_m` above the ground, pitched down by `pitch_rad`.
[[nodiscard]] Trajectory mounted(Trajectory carrier, double height_m, double pitch_rad, const Sway& sway);

}  // namespace kinetrace::simulator

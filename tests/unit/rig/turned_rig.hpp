// Points in front of a rig whose right camera deviates from its calibration.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/rig_correction.hpp"
#include "kinetrace/core/se3.hpp"
#include "synthetic_world.hpp"

namespace kinetrace::test {

constexpr double kDegree_rad = 0.017453292519943295;

[[nodiscard]] inline RigCorrection turned(double pitch_deg, double yaw_deg, double roll_deg, double down_deg = 0.0,
                                          double forward_deg = 0.0, double shift_deg = 0.0, double focal = 0.0) {
  return {kDegree_rad * Eigen::Vector3d(pitch_deg, yaw_deg, roll_deg),
          kDegree_rad * Eigen::Vector2d(down_deg, forward_deg), kDegree_rad * shift_deg, focal};
}

/// Pixels of both cameras, from the definition of RigCorrection. Right pixels are uncorrected.
struct SeenByBoth {
  Eigen::Vector2d left_px;
  Eigen::Vector2d right_px;
};
[[nodiscard]] inline SeenByBoth see(const StereoGeometry& g, const RigCorrection& rig, const Eigen::Vector3d& p_left) {
  const double scale = 1.0 + rig.focal;
  const auto pixel = [&g, scale](const Eigen::Vector3d& p) {
    return Eigen::Vector2d(scale * g.fx_px * p.x() / p.z() + g.cx_px, scale * g.fy_px * p.y() / p.z() + g.cy_px);
  };
  const Eigen::Vector3d direction(1.0, rig.baseline_rad.x(), rig.baseline_rad.y());
  const Eigen::Vector3d p_right = so3_exp(-rig.turn_rad) * (p_left - g.baseline_m * direction.normalized());
  return {pixel(p_left), pixel(p_right) - Eigen::Vector2d(scale * g.fx_px * rig.shift_rad, 0.0)};
}

/// Points at rest before a camera that drives: houses on both sides, a road below, sky above left out.
class StreetOfPoints {
 public:
  explicit StreetOfPoints(std::uint32_t seed) : random_(seed) {}

  [[nodiscard]] double noise(double sigma) { return sigma * std::normal_distribution<double>()(random_); }
  [[nodiscard]] double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  /// In the frame of a camera at the street's beginning.
  [[nodiscard]] Eigen::Vector3d point() {
    const double z_m = between(6.0, 45.0);
    return {between(-0.7, 0.7) * z_m, between(-0.2, 0.2) * z_m, z_m};
  }

 private:
  std::mt19937 random_;
};

}  // namespace kinetrace::test

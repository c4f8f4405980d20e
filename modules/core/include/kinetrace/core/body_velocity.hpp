// Velocity of a body between two poses, in its own axes, and how much it changes with time.
#pragma once

#include <cmath>
#include <optional>

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"

namespace kinetrace {

/// Standard deviations of the apparent velocity and turn rate of an object at rest, in addition to its covariance.
inline constexpr double kRestSpeedSigma_mps = 0.05;
inline constexpr double kRestTurnSigma_radps = 0.01;

/// Velocity (rad/s, m/s) and its derivatives by perturbations (rotation about the world's axes, position) of both
/// poses.
struct BodyVelocity {
  Vector6d value;
  Matrix6d by_from;
  Matrix6d by_to;
};

/// From T_world_body at one time to that `interval_s` > 0 later. The rotation between them is assumed small: the
/// derivative of the logarithm is taken at zero.
[[nodiscard]] inline BodyVelocity body_velocity(const Se3& from, const Se3& to, double interval_s) {
  const double rate = 1.0 / interval_s;
  const Eigen::Vector3d way = to.translation - from.translation;
  const Eigen::Matrix3d to_body = from.rotation.transpose();
  BodyVelocity v;
  v.value << rate * so3_log(to_body * to.rotation), rate * (to_body * way);
  v.by_to = Matrix6d::Zero();
  v.by_to.topLeftCorner<3, 3>() = rate * to.rotation.transpose();
  v.by_to.bottomRightCorner<3, 3>() = rate * to_body;
  v.by_from = -v.by_to;
  v.by_from.bottomLeftCorner<3, 3>() = rate * to_body * skew(way);
  return v;
}

/// Correlation time of an acceleration: as white noise, its spectral density is its variance times this.
inline constexpr double kAccelerationTime_s = 0.1;

/// Ratio of the standard deviation of the change of velocity over `span_s` to that of the acceleration. It grows with
/// the square root of time, so that the frame rate does not matter.
[[nodiscard]] inline double white_noise_span_s(double span_s) {
  return std::sqrt(kAccelerationTime_s * span_s);
}

/// Symmetric matrix with one eigenvalue along `normal`, of unit length, and another one in the plane across it.
[[nodiscard]] inline Eigen::Matrix3d by_direction(const Eigen::Vector3d& normal, double along, double across) {
  return across * Eigen::Matrix3d::Identity() + (along - across) * normal * normal.transpose();
}

/// White noise on acceleration (Bar-Shalom, Li, Kirubarajan 2001, sec. 6.2): standard deviations in one direction,
/// redrawn every kAccelerationTime_s. What moves on the ground moves along it and turns about its normal, `vertical`
/// (world axes). Where the ground is not known, `vertical` is empty, and all directions are alike.
struct MotionPrior {
  double acceleration_mps2 = 3.0;           ///< Along the ground.
  double vertical_acceleration_mps2 = 1.0;  ///< Along its normal.
  double turn_radps2 = 0.6;                 ///< Angular, about its normal.
  double tilt_radps2 = 0.2;                 ///< Angular, about directions along the ground.
  double vertical_speed_mps = 1.0;          ///< Speed along the normal: of slopes, and errors of the normal.

  [[nodiscard]] Eigen::Matrix3d acceleration_covariance(const std::optional<Eigen::Vector3d>& vertical) const {
    return matrix(vertical, vertical_acceleration_mps2 * vertical_acceleration_mps2,
                  acceleration_mps2 * acceleration_mps2, acceleration_mps2 * acceleration_mps2);
  }
  [[nodiscard]] Eigen::Matrix3d turn_covariance(const std::optional<Eigen::Vector3d>& vertical) const {
    return matrix(vertical, turn_radps2 * turn_radps2, tilt_radps2 * tilt_radps2, turn_radps2 * turn_radps2);
  }
  /// Of a velocity before anything is known of the path. `speed_mps`: standard deviation along the ground.
  [[nodiscard]] Eigen::Matrix3d velocity_covariance(const std::optional<Eigen::Vector3d>& vertical,
                                                    double speed_mps) const {
    return matrix(vertical, vertical_speed_mps * vertical_speed_mps, speed_mps * speed_mps, speed_mps * speed_mps);
  }
  /// Square root of its information, world axes.
  [[nodiscard]] Eigen::Matrix3d velocity_root_information(const std::optional<Eigen::Vector3d>& vertical,
                                                          double speed_mps) const {
    return matrix(vertical, 1.0 / vertical_speed_mps, 1.0 / speed_mps, 1.0 / speed_mps);
  }
  /// Square root of the information of a change of velocity (rad/s, m/s), in the body's own axes, over `span_s`.
  [[nodiscard]] Matrix6d root_information(const std::optional<Eigen::Vector3d>& vertical,
                                          const Eigen::Matrix3d& R_world_body, double span_s) const {
    std::optional<Eigen::Vector3d> in_body;
    if (vertical) {
      in_body = R_world_body.transpose() * *vertical;
    }
    const double ratio = 1.0 / white_noise_span_s(span_s);
    Matrix6d root = Matrix6d::Zero();
    root.topLeftCorner<3, 3>() = ratio * matrix(in_body, 1.0 / turn_radps2, 1.0 / tilt_radps2, 1.0 / turn_radps2);
    root.bottomRightCorner<3, 3>() =
        ratio * matrix(in_body, 1.0 / vertical_acceleration_mps2, 1.0 / acceleration_mps2, 1.0 / acceleration_mps2);
    return root;
  }

 private:
  [[nodiscard]] static Eigen::Matrix3d matrix(const std::optional<Eigen::Vector3d>& vertical, double along,
                                              double across, double unknown) {
    return vertical ? by_direction(*vertical, along, across) : Eigen::Matrix3d(unknown * Eigen::Matrix3d::Identity());
  }
};

}  // namespace kinetrace

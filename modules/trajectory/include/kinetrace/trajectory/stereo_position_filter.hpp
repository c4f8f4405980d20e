// Path of an object that has too few points for a reconstruction: constant-velocity Kalman filter on stereo positions
// and on the image motion of what is seen.
#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/trajectory/trajectory_config.hpp"

namespace kinetrace::trajectory {

/// How what is seen of an object has moved in the left image since the frame before.
struct ImageMotion {
  Eigen::Vector2d now_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d before_px = Eigen::Vector2d::Zero();
  int features = 0;  ///< That were tracked from frame to frame; these are their medians.
};

/// State: position and velocity in the world.
class StereoPositionFilter {
 public:
  StereoPositionFilter(const TrajectoryConfig& config, const StereoGeometry& geometry)
      : config_(config), geometry_(geometry) {}
  void reset() noexcept { initialised_ = false; }
  [[nodiscard]] bool initialised() const noexcept { return initialised_; }
  /// Starts at a known position and velocity. Something at rest (`at_rest`) is taken to stay there; of anything else
  /// the velocity is known to some metres per second and changes.
  void start(std::int64_t timestamp_ns, const Eigen::Vector3d& position_m, const Eigen::Vector3d& velocity_mps,
             const Eigen::Matrix3d& position_covariance, bool at_rest = false) noexcept;
  /// Moves the state to `timestamp_ns` without a measurement. Time that stands still or runs back changes nothing.
  void predict(std::int64_t timestamp_ns) noexcept;
  /// Takes in a stereo position at the time of the last `predict` or `start`: u_left, v and disparity of `features`
  /// points' medians. Errors of stereo are those of the image, so depth is as uncertain as its square (iterated
  /// extended Kalman filter). An implausible one is skipped (false), unless that happens three times in a row: then the
  /// filter starts again there. Before `start`, it starts at the first position, at rest. False too without a positive
  /// disparity or features. `surface_sigma_m` is how far the point seen may lie from the one that was followed so far:
  /// the middle of the visible surface drifts over an object.
  bool update(const Eigen::Vector3d& uvd_px, int features, const Se3& T_world_cam,
              double surface_sigma_m = 0.0) noexcept;

  /// Takes in where it is seen by one view, at the time of the last `predict` or `start`, its depth being what was
  /// expected: `sigma_m` is how far across the line of sight what is seen may lie from the point that is followed.
  void update_direction(const Eigen::Vector2d& uv_px, const Se3& T_world_cam, double sigma_m) noexcept;

  /// Takes in how its features have moved within `interval_s`, up to the time of the last `predict` or `start`. Unlike
  /// the middle of what is seen, they do not drift as more or less of it comes into sight. Skipped if implausible.
  void update_motion(const ImageMotion& motion, double interval_s, const Se3& T_world_cam,
                     const Se3& T_world_cam_before) noexcept;

  /// True if the last `update` found the object somewhere else and started again there.
  [[nodiscard]] bool jumped() const noexcept { return jumped_; }

  [[nodiscard]] bool at_rest() const noexcept { return at_rest_; }
  [[nodiscard]] const Eigen::Vector3d& position_m() const noexcept { return position_; }
  [[nodiscard]] const Eigen::Vector3d& velocity_mps() const noexcept { return velocity_; }
  [[nodiscard]] Eigen::Matrix3d position_covariance() const noexcept { return covariance_.topLeftCorner<3, 3>(); }

 private:
  void restart_at(const Eigen::Vector3d& uvd_px, double sigma_px, const Se3& T_world_cam,
                  double surface_sigma_m) noexcept;
  [[nodiscard]] Matrix6d process_noise(double dt_s) const noexcept;
  /// What a stereo position changes, and by what.
  struct StereoCorrection {
    Vector6d correction = Vector6d::Zero();
    Eigen::Matrix<double, 6, 3> gain = Eigen::Matrix<double, 6, 3>::Zero();
    Eigen::Matrix3d slope = Eigen::Matrix3d::Zero();  ///< Derivative of the measurement by position.
    Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
  };
  /// None for an implausible position.
  [[nodiscard]] std::optional<StereoCorrection> find_correction(const Eigen::Vector3d& uvd_px, double sigma_px,
                                                                const Se3& T_world_cam,
                                                                double surface_sigma_m) const noexcept;
  /// Takes in a measurement in the image, px, unless it is `gate` or more away (squared, in sigmas). `slope`: its
  /// derivative by position and velocity.
  void correct(const Eigen::Vector2d& innovation, const Eigen::Matrix<double, 2, 6>& slope,
               const Eigen::Matrix2d& noise, double gate) noexcept;

  TrajectoryConfig config_;
  StereoGeometry geometry_;
  bool initialised_ = false;
  bool at_rest_ = false;
  bool jumped_ = false;
  int skipped_ = 0;  ///< Implausible measurements in a row.
  std::int64_t timestamp_ns_ = 0;
  Eigen::Vector3d position_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();
  Matrix6d covariance_ = Matrix6d::Identity();
};

}  // namespace kinetrace::trajectory

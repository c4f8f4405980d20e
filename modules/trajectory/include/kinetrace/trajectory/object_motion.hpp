// Velocity, yaw rate and moving-or-not of one object from its recent poses.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "kinetrace/core/body.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/trajectory/trajectory_config.hpp"

namespace kinetrace::trajectory {

/// One frame of an object's path.
struct MotionSample {
  std::int64_t timestamp_ns = 0;
  Se3 T_world_obj;
  Eigen::Matrix3d position_covariance = Eigen::Matrix3d::Identity();  ///< Of the reference point in the world, m^2.
  /// Of the correlated position error, common to several frames and slowly varying, world, m^2: a resting object may
  /// drift by it over the window.
  Eigen::Matrix3d correlated_covariance = Eigen::Matrix3d::Zero();
  /// Of the drift of the visible part over the object, world, m^2: may look like a motion of the object, unless
  /// segmentation has found that it moves.
  Eigen::Matrix3d part_drift_covariance = Eigen::Matrix3d::Zero();
  bool detected_moving = false;  ///< By segmentation, see Detection::moving.
  bool is_evidence = true;       ///< Otherwise its position is no evidence of motion, and not used.
  /// Of the velocity error per pixel of common disparity error, world, (m/s/px)^2.
  Eigen::Matrix3d covariance_per_disparity = Eigen::Matrix3d::Zero();
};

/// Covariance of a point's velocity error due to a wrong calibration, per pixel of common disparity error, (m/s/px)^2.
/// A point p in the camera's frame with disparity d is off by p / d per pixel, which changes while the camera moves.
/// `ray_m` is p over its depth, `forward` the camera's viewing direction, `velocity_mps` the camera's, world frame. The
/// camera's velocity has the error of the points that it is estimated from; `background_disparity_px` is their median
/// disparity, 0: not known.
[[nodiscard]] Eigen::Matrix3d velocity_per_disparity(const Eigen::Vector3d& ray_m, const Eigen::Vector3d& forward,
                                                     const Eigen::Vector3d& velocity_mps, double disparity_px,
                                                     double background_disparity_px);

struct MotionEstimate {
  /// World frame, of the reference point; also if not significant.
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< Of the velocity.
  /// The same without the error of a wrong calibration, which the next frames have in common.
  Eigen::Matrix3d apparent_covariance = Eigen::Matrix3d::Zero();
  double yaw_rate_rad_s = 0.0;     ///< About the world's y axis (down).
  bool moving_by_path = false;     ///< Significant, and faster than min_moving_speed_mps.
  bool apparently_moving = false;  ///< The same by apparent_covariance.
  /// By its path, or by segmentation and its path together; an outlier of segmentation alone moves nothing.
  bool moving = false;
};

/// Ring buffer of the last kCapacity poses, newest at age 0. No heap.
class ObjectMotion {
 public:
  static constexpr std::size_t kCapacity = 48;
  /// Fewer give no velocity: two have no residuals that could reveal covariances that are too small.
  static constexpr std::size_t kMinSamples = 3;

  explicit ObjectMotion(const TrajectoryConfig& config) : config_(config), window_s_(config.velocity_window_s) {}
  /// People keep their velocity for longer, and their positions are less certain: a window twice as long. The ring
  /// bounds it: it is whole up to 24 frames a second on both sides, and before the newest frame up to 48.
  void set_gait(bool walks) noexcept { window_s_ = (walks ? 2.0 : 1.0) * config_.velocity_window_s; }
  void reset() noexcept;
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// Normal of the ground, world axes; nothing where the ground is not known.
  void set_vertical(const std::optional<Eigen::Vector3d>& vertical) noexcept { vertical_ = vertical; }
  /// Reference point of the path, object frame. Changing it applies to the whole ring.
  void set_reference(const Eigen::Vector3d& p_obj) noexcept { reference_obj_ = p_obj; }
  void push(const MotionSample& sample) noexcept;
  /// Standard deviation of the common error of all disparities.
  void set_disparity_sigma(double sigma_px) noexcept { disparity_sigma_px_ = sigma_px; }
  /// Replaces the pose of `age` frames ago; ages beyond size() are ignored.
  void revise(std::size_t age, const Se3& T_world_obj, const Eigen::Matrix3d& position_covariance) noexcept;
  /// Weighted least squares over the frames around `age`: constant velocity, or constant acceleration where it is
  /// significant. Significance is that of the velocity vector (root of its chi-square against zero), so that an
  /// uncertain depth does not mask a certain lateral motion. Hysteresis: an object whose sample or predecessor was
  /// moving when it was the newest stays moving down to half the significance. What segmentation has found moving in
  /// most of the frames moves if its path is half as significant, or as significant without the drift of its visible
  /// part. Fewer than kMinSamples, or an age beyond size(): no velocity, not moving.
  [[nodiscard]] MotionEstimate at(std::size_t age) const noexcept;

 private:
  struct Entry {
    MotionSample sample;
    bool was_moving = false;  ///< As assessed when it was the newest.
  };

  struct Window;
  [[nodiscard]] Window window(std::size_t age) const noexcept;
  [[nodiscard]] std::size_t slot(std::size_t age) const noexcept { return (head_ + kCapacity - age) % kCapacity; }
  [[nodiscard]] const Entry& entry(std::size_t age) const noexcept { return ring_[slot(age)]; }

  TrajectoryConfig config_;
  double window_s_ = 0.0;
  std::array<Entry, kCapacity> ring_;
  std::size_t head_ = 0;  ///< Slot of the newest.
  std::size_t size_ = 0;
  Eigen::Vector3d reference_obj_ = Eigen::Vector3d::Zero();
  double disparity_sigma_px_ = 0.0;
  std::optional<Eigen::Vector3d> vertical_;
};

}  // namespace kinetrace::trajectory

// Velocity, heading and moving-or-not of one object from its recent poses.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "kinetrace/core/body.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/trajectory/trajectory_config.hpp"

namespace kinetrace::trajectory {

/// One frame of an object's path.
struct MotionSample {
  std::int64_t timestamp_ns = 0;
  Se3 T_world_obj;
  Eigen::Matrix3d position_covariance = Eigen::Matrix3d::Identity();  ///< Of the reference point in the world, m^2.
  /// By how much the position may drift over the window while the object stands still, world, m^2: errors that frames
  /// have in common and that change slowly.
  Eigen::Matrix3d correlated_covariance = Eigen::Matrix3d::Zero();
  /// Of the velocity that it has from a common error of all disparities of one pixel, world, (m/s/px)^2.
  Eigen::Matrix3d covariance_per_disparity = Eigen::Matrix3d::Zero();
};

/// What a wrong calibration does to the velocity of a point, by a common error of all disparities: with disparity d and
/// p its place in the camera's frame, p is off by p / d a pixel, and while the camera moves, that changes. `ray_m` is p
/// over its depth, `forward` where the camera looks, `velocity_mps` the camera's, world frame. The camera's own
/// velocity is off as are the points that it is found from, whose median disparity is `background_disparity_px`; 0: not
/// known. (m/s/px)^2.
[[nodiscard]] Eigen::Matrix3d velocity_per_disparity(const Eigen::Vector3d& ray_m, const Eigen::Vector3d& forward,
                                                     const Eigen::Vector3d& velocity_mps, double disparity_px,
                                                     double background_disparity_px);

struct MotionEstimate {
  /// World frame, of the reference point, whether it differs significantly from zero or not.
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< Of the velocity.
  /// ... but for what a wrong calibration may add, which the next frames show alike.
  Eigen::Matrix3d apparent_covariance = Eigen::Matrix3d::Zero();
  double yaw_rate_rad_s = 0.0;     ///< About the world's y axis (down).
  bool moving = false;             ///< Significant, and faster than min_moving_speed_mps.
  bool apparently_moving = false;  ///< The same by apparent_covariance.
};

/// A fixed ring of the last kCapacity poses, newest at age 0; the oldest gives way. No heap.
class ObjectMotion {
 public:
  static constexpr std::size_t kCapacity = 48;
  /// Fewer show no velocity: two cannot show that their covariances are too small.
  static constexpr std::size_t kMinSamples = 3;

  explicit ObjectMotion(const TrajectoryConfig& config) : config_(config) {}
  void reset() noexcept;
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// Point of the object whose path is followed (centre of its box), object frame. Changing it applies to the whole
  /// ring.
  void set_reference(const Eigen::Vector3d& p_obj) noexcept { reference_obj_ = p_obj; }
  void push(const MotionSample& sample) noexcept;
  /// By how much all disparities may be off.
  void set_disparity_sigma(double sigma_px) noexcept { disparity_sigma_px_ = sigma_px; }
  /// Replaces the pose of `age` frames ago; ages beyond size() are ignored.
  void revise(std::size_t age, const Se3& T_world_obj, const Eigen::Matrix3d& position_covariance) noexcept;
  /// Weighted least squares over the frames around `age`: constant velocity, or constant acceleration where the path
  /// shows it. Significance is that of the velocity vector (root of its chi-square against zero), so that a sure
  /// lateral motion is not drowned by an uncertain depth; an object whose sample or predecessor was found moving when
  /// it was new stays so down to half the significance. Fewer than kMinSamples, or an age beyond size(): no velocity,
  /// not moving.
  [[nodiscard]] MotionEstimate at(std::size_t age) const noexcept;

 private:
  struct Entry {
    MotionSample sample;
    bool was_moving = false;  ///< As assessed when it was the newest.
  };

  [[nodiscard]] std::size_t slot(std::size_t age) const noexcept { return (head_ + kCapacity - age) % kCapacity; }
  [[nodiscard]] const Entry& entry(std::size_t age) const noexcept { return ring_[slot(age)]; }

  TrajectoryConfig config_;
  std::array<Entry, kCapacity> ring_;
  std::size_t head_ = 0;  ///< Slot of the newest.
  std::size_t size_ = 0;
  Eigen::Vector3d reference_obj_ = Eigen::Vector3d::Zero();
  double disparity_sigma_px_ = 0.0;
};

}  // namespace kinetrace::trajectory

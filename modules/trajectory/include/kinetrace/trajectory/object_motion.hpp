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
};

struct MotionEstimate {
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< World frame, of the reference point.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();    ///< Of the velocity.
  double yaw_rate_rad_s = 0.0;
  bool moving = false;
};

/// A fixed ring of the last kCapacity poses, newest at age 0. No heap.
class ObjectMotion {
 public:
  static constexpr std::size_t kCapacity = 48;

  explicit ObjectMotion(const TrajectoryConfig& config) : config_(config) {}
  void reset() noexcept;
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// Point of the object whose path is followed (centre of its box), object frame. Changing it applies to the whole
  /// ring.
  void set_reference(const Eigen::Vector3d& p_obj) noexcept { reference_obj_ = p_obj; }
  void push(const MotionSample& sample) noexcept;
  /// Replaces the pose of `age` frames ago; ages beyond size() are ignored.
  void revise(std::size_t age, const Se3& T_world_obj, const Eigen::Matrix3d& position_covariance) noexcept;
  /// Weighted least squares over the frames around `age`. One sample: no velocity, not moving.
  [[nodiscard]] MotionEstimate at(std::size_t age) const noexcept;

 private:
  TrajectoryConfig config_;
  std::array<MotionSample, kCapacity> ring_;
  std::size_t head_ = 0;
  std::size_t size_ = 0;
  Eigen::Vector3d reference_obj_ = Eigen::Vector3d::Zero();
  bool moving_ = false;  ///< Hysteresis of the newest estimate.
};

}  // namespace kinetrace::trajectory

#include "kinetrace/trajectory/object_motion.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/Cholesky>

#include "kinetrace/core/stereo_geometry.hpp"
#include "velocity_fit.hpp"

namespace kinetrace::trajectory {
namespace {

constexpr double kTimestampJitter_s = 0.03;  // A frame that is as late still belongs to the window.
// Samples farther away in time do not represent the velocity, whatever their number.
constexpr double kMaxSampleAge_s = 2.0;
// Lower bounds for errors that covariances omit: those below a centimetre, and those that drift over frames.
constexpr double kPositionFloor_m = 0.01;
constexpr double kVelocityFloor_mps = 0.05;
constexpr double kStopRatio = 0.5;

double seconds_between(std::int64_t from_ns, std::int64_t to_ns) {
  return 1e-9 * static_cast<double>(to_ns - from_ns);
}

Eigen::Matrix3d information_of(const Eigen::Matrix3d& covariance) {
  return (covariance + kPositionFloor_m * kPositionFloor_m * Eigen::Matrix3d::Identity())
      .ldlt()
      .solve(Eigen::Matrix3d::Identity());
}

/// Rate of rotation about the world's y axis, by least squares, relative to the centre's rotation.
struct TurnRate {
  double sum_t = 0.0, sum_tt = 0.0, sum_a = 0.0, sum_ta = 0.0;
  double count = 0.0;

  void add(double time_s, double angle_rad) {
    sum_t += time_s;
    sum_tt += time_s * time_s;
    sum_a += angle_rad;
    sum_ta += time_s * angle_rad;
    count += 1.0;
  }
  [[nodiscard]] double rad_s() const {
    const double spread = sum_tt - sum_t * sum_t / count;
    return spread > 0.0 ? (sum_ta - sum_t * sum_a / count) / spread : 0.0;
  }
};

}  // namespace

Eigen::Matrix3d velocity_per_disparity(const Eigen::Vector3d& ray_m, const Eigen::Vector3d& forward,
                                       const Eigen::Vector3d& velocity_mps, double disparity_px,
                                       double background_disparity_px) {
  const Eigen::Vector3d of_point = (velocity_mps + forward.dot(velocity_mps) * ray_m) / disparity_px;
  Eigen::Matrix3d covariance = of_point * of_point.transpose();
  if (background_disparity_px > 0.0) {
    const Eigen::Vector3d of_camera = 2.0 * velocity_mps / background_disparity_px;
    covariance += of_camera * of_camera.transpose();
  }
  return covariance;
}

void ObjectMotion::reset() noexcept {
  size_ = 0;
  reference_obj_.setZero();
}

void ObjectMotion::push(const MotionSample& sample) noexcept {
  head_ = (head_ + 1) % kCapacity;
  size_ = std::min(size_ + 1, kCapacity);
  ring_[head_] = {sample, false};
  ring_[head_].was_moving = at(0).moving;
}

void ObjectMotion::revise(std::size_t age, const Se3& T_world_obj,
                          const Eigen::Matrix3d& position_covariance) noexcept {
  if (age < size_) {
    MotionSample& sample = ring_[slot(age)].sample;
    sample.T_world_obj = T_world_obj;
    sample.position_covariance = position_covariance;
  }
}

MotionEstimate ObjectMotion::at(std::size_t age) const noexcept {
  MotionEstimate estimate;
  if (age >= size_) {
    return estimate;
  }
  const MotionSample& center = entry(age).sample;
  std::array<PathPoint, kCapacity> path;
  std::size_t count = 0;
  TurnRate turn;
  Eigen::Matrix3d correlated_covariance = center.correlated_covariance;  // The largest in the window.
  for (std::size_t i = 0; i < size_; ++i) {
    const MotionSample& sample = entry(i).sample;
    const double time_s = seconds_between(center.timestamp_ns, sample.timestamp_ns);
    const bool is_neighbour = i + 1 >= age && i <= age + 1;  // the only ones of a slow camera
    if (sample.is_evidence && std::abs(time_s) <= (is_neighbour ? kMaxSampleAge_s : window_s_ + kTimestampJitter_s)) {
      path[count++] = {time_s, sample.T_world_obj * reference_obj_, information_of(sample.position_covariance)};
      correlated_covariance = sample.correlated_covariance.trace() > correlated_covariance.trace()
                                  ? sample.correlated_covariance
                                  : correlated_covariance;
      turn.add(time_s, so3_log(sample.T_world_obj.rotation * center.T_world_obj.rotation.transpose()).y());
    }
  }
  if (count < 2) {
    return estimate;
  }
  const VelocityFit fit = fit_velocity(std::span<const PathPoint>(path).first(count));
  estimate.covariance = fit.covariance + kVelocityFloor_mps * kVelocityFloor_mps * Eigen::Matrix3d::Identity();
  estimate.yaw_rate_rad_s = turn.rad_s();
  const double correlation_s = std::max(path[0].time_s - path[count - 1].time_s, kErrorCorrelation_s);
  estimate.covariance += correlated_covariance / (correlation_s * correlation_s);
  estimate.apparent_covariance = estimate.covariance;
  estimate.covariance += disparity_sigma_px_ * disparity_sigma_px_ * center.covariance_per_disparity;
  const bool was_moving = entry(age).was_moving || (age + 1 < size_ && entry(age + 1).was_moving);
  const double min_significance = config_.moving_significance * (was_moving ? kStopRatio : 1.0);
  const auto exceeds = [&](double significance, const Eigen::Matrix3d& covariance) {
    const double chi_square = fit.velocity_mps.dot(covariance.ldlt().solve(fit.velocity_mps));
    return chi_square > significance * significance && fit.velocity_mps.norm() > config_.min_moving_speed_mps;
  };
  if (count >= kMinSamples) {
    estimate.velocity_mps = fit.velocity_mps;
    estimate.moving = exceeds(min_significance, estimate.covariance);
    estimate.apparently_moving = exceeds(config_.moving_significance, estimate.apparent_covariance);
  }
  return estimate;
}

}  // namespace kinetrace::trajectory

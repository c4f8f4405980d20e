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

/// The covariance with the largest trace.
struct Largest {
  Eigen::Matrix3d covariance;

  void add(const Eigen::Matrix3d& other) noexcept {
    if (other.trace() > covariance.trace()) {
      covariance = other;
    }
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
  ring_[head_].was_moving = at(0).moving_by_path;
}

void ObjectMotion::revise(std::size_t age, const Se3& T_world_obj,
                          const Eigen::Matrix3d& position_covariance) noexcept {
  if (age < size_) {
    MotionSample& sample = ring_[slot(age)].sample;
    sample.T_world_obj = T_world_obj;
    sample.position_covariance = position_covariance;
  }
}

/// The samples around an age that are evidence of motion.
struct ObjectMotion::Window {
  std::array<PathPoint, kCapacity> path{};
  std::size_t count = 0;
  TurnRate turn{};
  Largest correlated;  ///< Errors that the samples have in common...
  Largest drifting;    ///< ...and with the drift of the visible part.
  std::size_t detected_moving = 0;

  [[nodiscard]] std::span<const PathPoint> points() const noexcept { return std::span(path).first(count); }
  [[nodiscard]] double correlation_s() const noexcept {
    return std::max(path[0].time_s - path[count - 1].time_s, kErrorCorrelation_s);
  }
};

ObjectMotion::Window ObjectMotion::window(std::size_t age) const noexcept {
  const MotionSample& center = entry(age).sample;
  Window window{.correlated = {center.correlated_covariance},
                .drifting = {center.correlated_covariance + center.part_drift_covariance}};
  for (std::size_t i = 0; i < size_; ++i) {
    const MotionSample& sample = entry(i).sample;
    const double time_s = seconds_between(center.timestamp_ns, sample.timestamp_ns);
    const bool is_neighbour = i + 1 >= age && i <= age + 1;  // the only ones of a slow camera
    if (!sample.is_evidence || std::abs(time_s) > (is_neighbour ? kMaxSampleAge_s : window_s_ + kTimestampJitter_s)) {
      continue;
    }
    window.path[window.count++] = {time_s, sample.T_world_obj * reference_obj_,
                                   information_of(sample.position_covariance)};
    window.correlated.add(sample.correlated_covariance);
    window.drifting.add(sample.correlated_covariance + sample.part_drift_covariance);
    window.detected_moving += sample.detected_moving ? 1 : 0;
    window.turn.add(time_s, so3_log(sample.T_world_obj.rotation * center.T_world_obj.rotation.transpose()).y());
  }
  return window;
}

MotionEstimate ObjectMotion::at(std::size_t age) const noexcept {
  MotionEstimate estimate;
  if (age >= size_) {
    return estimate;
  }
  const Window window = this->window(age);
  if (window.count < 2) {
    return estimate;
  }
  const VelocityFit fit =
      fit_velocity(window.points(), config_.motion.velocity_covariance(vertical_, kSpeedPriorSigma_mps).inverse());
  const double per_s2 = 1.0 / (window.correlation_s() * window.correlation_s());
  const Eigen::Matrix3d calibration_covariance =
      disparity_sigma_px_ * disparity_sigma_px_ * entry(age).sample.covariance_per_disparity;
  const Eigen::Matrix3d fit_covariance =
      fit.covariance + kVelocityFloor_mps * kVelocityFloor_mps * Eigen::Matrix3d::Identity();
  estimate.apparent_covariance = fit_covariance + per_s2 * window.drifting.covariance;
  estimate.covariance = estimate.apparent_covariance + calibration_covariance;
  estimate.yaw_rate_rad_s = window.turn.rad_s();
  if (window.count < kMinSamples) {
    return estimate;
  }
  estimate.velocity_mps = fit.velocity_mps;
  const auto exceeds = [&](double significance, const Eigen::Matrix3d& covariance) {
    const double chi_square = fit.velocity_mps.dot(covariance.ldlt().solve(fit.velocity_mps));
    return chi_square > significance * significance && fit.velocity_mps.norm() > config_.min_moving_speed_mps;
  };
  const double to_begin = config_.moving_significance;
  const double to_continue = kStopRatio * to_begin;
  const bool was_moving = entry(age).was_moving || (age + 1 < size_ && entry(age + 1).was_moving);
  estimate.moving_by_path = exceeds(was_moving ? to_continue : to_begin, estimate.covariance);
  estimate.apparently_moving = exceeds(to_begin, estimate.apparent_covariance);
  const bool is_detected_moving = 2 * window.detected_moving > window.count;
  estimate.moving =
      estimate.moving_by_path ||
      (is_detected_moving &&
       (exceeds(to_continue, estimate.covariance) ||
        exceeds(to_begin, fit_covariance + calibration_covariance + per_s2 * window.correlated.covariance)));
  return estimate;
}

}  // namespace kinetrace::trajectory

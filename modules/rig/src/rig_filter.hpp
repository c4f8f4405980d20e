// Filter of the right camera's pose over time, from measurements of pairs of frames.
#pragma once

#include <cstdint>

#include "kinetrace/core/rig_correction.hpp"
#include "two_view_calibration.hpp"

namespace kinetrace::rig {

/// Process noise of a rig: standard deviation of its rate of change, with a correlation time of some seconds. Focal
/// lengths do not turn with a mount; they have a random walk of their own.
struct RigMotion {
  double rate_sigma_radps = 0.0;
  double random_walk_rad_per_root_s = 0.0;
  double focal_walk_per_root_s = 0.0;

  [[nodiscard]] RigCorrection::Vector rate_variance() const;
  /// Variance of the random walk after one second.
  [[nodiscard]] RigCorrection::Vector walk_variance() const;
};

/// Kalman filter over the correction and its rate of change, an Ornstein-Uhlenbeck process.
class RigKalmanFilter {
 public:
  using Vector = RigMeasurement::Vector;
  using Matrix = RigMeasurement::Matrix;

  RigKalmanFilter() = default;
  RigKalmanFilter(const RigMotion& motion, const RigCorrection::Vector& prior_sigma_rad);

  void predict(double interval_s);
  /// Predicted correction, and its change over the last `interval_s`.
  [[nodiscard]] Vector expected(double interval_s) const;
  struct Innovation {
    double nis = 0.0;             ///< Normalised innovation squared; RigMeasurement::kSize degrees of freedom.
    double log_likelihood = 0.0;  ///< Without terms common to all filters.
  };
  [[nodiscard]] Innovation innovation(const RigMeasurement& measured, double interval_s, double inflation) const;
  void update(const RigMeasurement& measured, double interval_s, double inflation);
  /// Restarts from a measurement, except for the focal length.
  void restart(const RigMeasurement& measured, double interval_s, double inflation);
  /// Copies the other filter's correction; keeps its own rates.
  void take_correction(const RigKalmanFilter& other);

  [[nodiscard]] RigCorrection::Vector correction() const { return state_.head<RigCorrection::kSize>(); }
  [[nodiscard]] RigCorrection::Matrix covariance() const {
    return covariance_.topLeftCorner<RigCorrection::kSize, RigCorrection::kSize>();
  }

 private:
  [[nodiscard]] static Matrix observation(double interval_s);

  RigMotion motion_;
  Vector state_ = Vector::Zero();
  Matrix covariance_ = Matrix::Zero();
};

/// Two filters in parallel, for a steady and for a drifting rig; the likelihoods of the measurements select one
/// (multiple model estimation; Bar-Shalom, Li, Kirubarajan, "Estimation with applications to tracking and navigation",
/// 2001). A knock, unexpected by both filters, is accepted once two successive measurements agree. Measurements that
/// scatter more than their covariance are down-weighted from then on.
class RigFilter {
 public:
  RigFilter() = default;
  explicit RigFilter(const RigCorrection::Vector& prior_sigma_rad);

  void predict(double interval_s);
  void update(const RigMeasurement& measured, double interval_s);

  [[nodiscard]] RigKalmanFilter::Vector expected(double interval_s) const { return likelier().expected(interval_s); }
  [[nodiscard]] RigCorrection::Vector correction() const { return likelier().correction(); }
  [[nodiscard]] RigCorrection::Matrix covariance() const { return likelier().covariance(); }
  [[nodiscard]] bool holds_still() const noexcept { return steady_log_likelihood_ratio_ >= 0.0; }
  /// Ratio of the measurements' actual to their formal variance, 1 or more.
  [[nodiscard]] double scatter() const noexcept { return inflation_; }
  [[nodiscard]] std::uint64_t updates() const noexcept { return updates_; }
  [[nodiscard]] std::uint64_t knocks() const noexcept { return knocks_; }

 private:
  [[nodiscard]] const RigKalmanFilter& likelier() const noexcept { return holds_still() ? steady_ : drifting_; }
  /// True if the measurement needs no further processing.
  bool handle_unexpected(const RigMeasurement& measured, double interval_s);

  RigKalmanFilter steady_;
  RigKalmanFilter drifting_;
  double steady_log_likelihood_ratio_ = 0.0;  ///< Log-likelihood ratio of steady against drifting.
  double inflation_ = 1.0;                    ///< Factor of the measurements' covariance.
  RigMeasurement unexpected_measurement_;     ///< The last measurement, if unexpected.
  std::uint64_t updates_ = 0;
  std::uint64_t knocks_ = 0;
};

}  // namespace kinetrace::rig

// The right camera's pose over time, from measurements of pairs of frames.
#pragma once

#include <cstdint>

#include "kinetrace/core/rig_correction.hpp"
#include "two_view_calibration.hpp"

namespace kinetrace::rig {

/// How a rig may change: the deviation of its rate of change, which lasts for some seconds. Focal lengths do not turn
/// with a mount; they have a random walk of their own.
struct RigMotion {
  double rate_sigma_radps = 0.0;
  double random_walk_rad_per_root_s = 0.0;
  double focal_walk_per_root_s = 0.0;

  [[nodiscard]] RigCorrection::Vector rate_variance() const;
  /// Of the random walk in a second.
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
  /// Correction expected now, and its change over the last `interval_s`.
  [[nodiscard]] Vector expected(double interval_s) const;
  struct Innovation {
    double nis = 0.0;             ///< Normalised squared; as many degrees of freedom as a measurement has entries.
    double log_likelihood = 0.0;  ///< Less what is the same for every filter.
  };
  [[nodiscard]] Innovation innovation(const RigMeasurement& measured, double interval_s, double inflation) const;
  void update(const RigMeasurement& measured, double interval_s, double inflation);
  /// Begins anew with what was measured, but for the focal length.
  void restart(const RigMeasurement& measured, double interval_s, double inflation);
  /// Takes over the other one's correction; its own belief about rates stays.
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

/// Two filters beside each other, for a rig that holds still and for one that drifts; the likelihoods of what is
/// measured decide which is taken (Bar-Shalom, Li, Kirubarajan, "Estimation with applications to tracking and
/// navigation", 2001, multiple model estimation). What neither expects is taken once two measurements in a row say it:
/// a knock. Measurements that scatter more than their covariance says count for less from then on.
class RigFilter {
 public:
  RigFilter() = default;
  explicit RigFilter(const RigCorrection::Vector& prior_sigma_rad);

  void predict(double interval_s);
  void update(const RigMeasurement& measured, double interval_s);

  [[nodiscard]] RigKalmanFilter::Vector expected(double interval_s) const { return likelier().expected(interval_s); }
  [[nodiscard]] RigCorrection::Vector correction() const { return likelier().correction(); }
  [[nodiscard]] RigCorrection::Matrix covariance() const { return likelier().covariance(); }
  [[nodiscard]] bool holds_still() const noexcept { return steady_odds_ >= 0.0; }
  /// How much more the measurements scatter than they say: variance over variance, 1 or more.
  [[nodiscard]] double scatter() const noexcept { return inflation_; }
  [[nodiscard]] std::uint64_t updates() const noexcept { return updates_; }
  [[nodiscard]] std::uint64_t knocks() const noexcept { return knocks_; }

 private:
  [[nodiscard]] const RigKalmanFilter& likelier() const noexcept { return holds_still() ? steady_ : drifting_; }
  /// True if the measurement has been dealt with.
  bool handle_surprise(const RigMeasurement& measured, double interval_s);

  RigKalmanFilter steady_;
  RigKalmanFilter drifting_;
  double steady_odds_ = 0.0;  ///< Log-likelihood of holding still over that of drifting.
  double inflation_ = 1.0;    ///< Of the measurements' covariance.
  RigMeasurement surprise_;   ///< The last one, if nobody expected it.
  std::uint64_t updates_ = 0;
  std::uint64_t knocks_ = 0;
};

}  // namespace kinetrace::rig

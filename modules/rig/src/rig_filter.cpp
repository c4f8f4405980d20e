#include "rig_filter.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace kinetrace::rig {
namespace {

constexpr int kN = RigCorrection::kSize;

// Correlation time of a rig's rate of change.
constexpr double kRateLasts_s = 2.0;
// Steady: screws and glue, a hundredth of a pixel per second at the usual focal lengths. Drifting: a hand-held rig or
// changing temperature, a pixel per second.
// Focal lengths: 20 to 50 millionths per kelvin, a kelvin in some seconds.
constexpr RigMotion kSteady{.rate_sigma_radps = 0.0, .random_walk_rad_per_root_s = 1e-5, .focal_walk_per_root_s = 1e-5};
constexpr RigMotion kDrifting{
    .rate_sigma_radps = 1.5e-3, .random_walk_rad_per_root_s = 3e-5, .focal_walk_per_root_s = 1e-5};
// NIS over its expectation: beyond the first a measurement is unexpected; below the second, two unexpected ones agree.
constexpr double kUnexpectedNis = 6.0;
constexpr double kAgreeingNis = 4.0;
// Gain of the running estimate of the measurements' scatter.
constexpr double kScatterGain = 0.15;
constexpr double kMaxInflation = 200.0;
// Initial value: real lenses and textures are worse than the noise model.
constexpr double kFirstInflation = 3.0;
// Decay of old log-likelihood ratios per measurement, and their bound.
constexpr double kLogRatioKept = 0.85;
constexpr double kMaxLogRatio = 8.0;

}  // namespace

RigCorrection::Vector RigMotion::rate_variance() const {
  RigCorrection::Vector variance = RigCorrection::Vector::Constant(rate_sigma_radps * rate_sigma_radps);
  variance[RigCorrection::kFocal] = 0.0;
  return variance;
}

RigCorrection::Vector RigMotion::walk_variance() const {
  RigCorrection::Vector variance =
      RigCorrection::Vector::Constant(random_walk_rad_per_root_s * random_walk_rad_per_root_s);
  variance[RigCorrection::kFocal] = focal_walk_per_root_s * focal_walk_per_root_s;
  return variance;
}

RigKalmanFilter::RigKalmanFilter(const RigMotion& motion, const RigCorrection::Vector& prior_sigma_rad)
    : motion_(motion) {
  covariance_.diagonal().head<kN>() = prior_sigma_rad.array().square();
  covariance_.diagonal().tail<kN>() = motion.rate_variance();
}

void RigKalmanFilter::predict(double interval_s) {
  const double kept = std::exp(-interval_s / kRateLasts_s);
  Matrix F = Matrix::Identity();
  F.topRightCorner<kN, kN>().diagonal().setConstant(kRateLasts_s * (1.0 - kept));
  F.bottomRightCorner<kN, kN>().diagonal().setConstant(kept);
  state_ = F * state_;
  covariance_ = F * covariance_ * F.transpose();
  const RigCorrection::Vector rate = motion_.rate_variance() * (1.0 - kept * kept);
  covariance_.diagonal().head<kN>() += motion_.walk_variance() * interval_s + rate * interval_s * interval_s / 3.0;
  covariance_.diagonal().tail<kN>() += rate;
  covariance_.topRightCorner<kN, kN>().diagonal() += rate * interval_s / 2.0;
  covariance_.bottomLeftCorner<kN, kN>().diagonal() += rate * interval_s / 2.0;
}

RigKalmanFilter::Matrix RigKalmanFilter::observation(double interval_s) {
  Matrix H = Matrix::Identity();
  H.bottomRightCorner<kN, kN>().diagonal().setConstant(interval_s);
  return H;
}

RigKalmanFilter::Vector RigKalmanFilter::expected(double interval_s) const {
  return observation(interval_s) * state_;
}

RigKalmanFilter::Innovation RigKalmanFilter::innovation(const RigMeasurement& measured, double interval_s,
                                                        double inflation) const {
  const Matrix H = observation(interval_s);
  const Matrix S = H * covariance_ * H.transpose() + inflation * measured.covariance;
  const Vector difference = measured.value - H * state_;
  const Eigen::LLT<Matrix> factor(S);
  const Vector whitened = factor.matrixL().solve(difference);
  const Matrix lower = factor.matrixL();
  const double nis = whitened.squaredNorm();
  return {nis, -0.5 * nis - lower.diagonal().array().log().sum()};
}

void RigKalmanFilter::update(const RigMeasurement& measured, double interval_s, double inflation) {
  const Matrix H = observation(interval_s);
  const Matrix S = H * covariance_ * H.transpose() + inflation * measured.covariance;
  const Matrix gain = S.llt().solve(H * covariance_).transpose();
  state_ += gain * (measured.value - H * state_);
  // Joseph form: stays positive definite.
  const Matrix kept = Matrix::Identity() - gain * H;
  covariance_ = kept * covariance_ * kept.transpose() + gain * (inflation * measured.covariance) * gain.transpose();
}

void RigKalmanFilter::restart(const RigMeasurement& measured, double interval_s, double inflation) {
  constexpr int kMount = RigCorrection::kFocal;  // States that a knock can change.
  const RigCorrection::Vector rate = motion_.rate_variance();
  const double focal = state_[kMount];
  const double focal_variance = covariance_(kMount, kMount);
  state_.setZero();
  state_.head<kMount>() = measured.value.head<kMount>();
  state_[kMount] = focal;
  covariance_.setZero();
  covariance_.topLeftCorner<kMount, kMount>() = inflation * measured.covariance.topLeftCorner<kMount, kMount>();
  covariance_(kMount, kMount) = focal_variance;
  covariance_.diagonal().head<kN>() += interval_s * interval_s * rate;
  covariance_.diagonal().tail<kN>() = rate;
}

void RigKalmanFilter::take_correction(const RigKalmanFilter& other) {
  state_.head<kN>() = other.state_.head<kN>();
  covariance_.topLeftCorner<kN, kN>() = other.covariance_.topLeftCorner<kN, kN>();
  covariance_.topRightCorner<kN, kN>().setZero();
  covariance_.bottomLeftCorner<kN, kN>().setZero();
}

RigFilter::RigFilter(const RigCorrection::Vector& prior_sigma_rad)
    : steady_(kSteady, prior_sigma_rad), drifting_(kDrifting, prior_sigma_rad), inflation_(kFirstInflation) {}

void RigFilter::predict(double interval_s) {
  steady_.predict(interval_s);
  drifting_.predict(interval_s);
}

bool RigFilter::handle_unexpected(const RigMeasurement& measured, double interval_s) {
  const double limit = kUnexpectedNis * RigMeasurement::kSize;
  if (drifting_.innovation(measured, interval_s, inflation_).nis < limit) {
    unexpected_measurement_.valid = false;
    return false;
  }
  if (unexpected_measurement_.valid) {
    RigKalmanFilter knocked = drifting_;
    knocked.restart(unexpected_measurement_, interval_s, inflation_);
    knocked.predict(interval_s);
    if (knocked.innovation(measured, interval_s, inflation_).nis < kAgreeingNis * RigMeasurement::kSize) {
      knocked.update(measured, interval_s, inflation_);
      drifting_ = knocked;
      steady_.take_correction(knocked);
      unexpected_measurement_.valid = false;
      ++knocks_;
      return true;
    }
  }
  // An outlier, or a knock that the next measurement will confirm; or else all measurements scatter more than assumed.
  unexpected_measurement_ = measured;
  inflation_ = std::min(kMaxInflation, 2.0 * inflation_);
  return true;
}

void RigFilter::update(const RigMeasurement& measured, double interval_s) {
  ++updates_;
  if (handle_unexpected(measured, interval_s)) {
    return;
  }
  const RigKalmanFilter::Innovation still = steady_.innovation(measured, interval_s, inflation_);
  const RigKalmanFilter::Innovation drift = drifting_.innovation(measured, interval_s, inflation_);
  steady_log_likelihood_ratio_ =
      std::clamp(kLogRatioKept * steady_log_likelihood_ratio_ + still.log_likelihood - drift.log_likelihood,
                 -kMaxLogRatio, kMaxLogRatio);
  steady_.update(measured, interval_s, inflation_);
  drifting_.update(measured, interval_s, inflation_);
  const double scatter = inflation_ * std::min(still.nis, drift.nis) / RigMeasurement::kSize;
  inflation_ = std::clamp((1.0 - kScatterGain) * inflation_ + kScatterGain * scatter, 1.0, kMaxInflation);
  if (steady_log_likelihood_ratio_ <= -kMaxLogRatio) {
    steady_.take_correction(drifting_);
  }
}

}  // namespace kinetrace::rig

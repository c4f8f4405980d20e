#include "kinetrace/objects/motion_filter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "kinetrace/core/body_velocity.hpp"
#include "kinetrace/core/median.hpp"

namespace kinetrace::objects {
namespace {

/// Apparent drift of an object at rest in one second: errors of the camera's path and of the masks.
constexpr double kRestDrift_m = 0.02;
/// Mean dwell times: at rest, mostly parked, and moving, until a stop in traffic.
constexpr std::array<double, 2> kDwell_s{200.0, 20.0};
/// A fitted velocity is that of the middle of its path, this long ago.
constexpr double kVelocityLag_s = 0.3;
constexpr double kNoGate = std::numeric_limits<double>::infinity();
constexpr int kIterations = 3;
/// Errors of the points of one object are correlated: more features do not improve their median.
constexpr int kMaxIndependentFeatures = 4;
constexpr double kMinProbability = 1e-6;
/// Prior standard deviation of velocities on streets; a measured velocity less certain than this is mostly noise.
constexpr double kVelocityPriorSigma_mps = 20.0;

/// A measurement of N numbers at a state: residual, Jacobian by position and velocity, covariance of its noise.
template <int N>
struct Observation {
  Eigen::Matrix<double, N, 1> residual;
  Eigen::Matrix<double, N, 6> jacobian;
  Eigen::Matrix<double, N, N> noise;
};

/// (u_left, v, disparity) of a point in the camera frame, and its Jacobian.
struct Projection {
  Eigen::Vector3d uvd_px;
  Eigen::Matrix3d jacobian;
};

Projection project(const StereoGeometry& g, const Eigen::Vector3d& p) {
  const double inv_z = 1.0 / p.z();
  const double bf = g.fx_px * g.baseline_m;
  Projection out;
  out.uvd_px << g.fx_px * p.x() * inv_z + g.cx_px, g.fy_px * p.y() * inv_z + g.cy_px, bf * inv_z;
  out.jacobian << g.fx_px * inv_z, 0.0, -g.fx_px * p.x() * inv_z * inv_z,  //
      0.0, g.fy_px * inv_z, -g.fy_px * p.y() * inv_z * inv_z,              //
      0.0, 0.0, -bf * inv_z * inv_z;
  return out;
}

double median_sigma_px(double sigma_px, int features) {
  return sigma_px / std::sqrt(static_cast<double>(std::min(features, kMaxIndependentFeatures)));
}

bool is_measured(const StereoPosition& measured) {
  return measured.features > 0 && measured.uvd_px.allFinite() && measured.uvd_px.z() > 0.0;
}

/// The first N of (u_left, v, disparity) of the visible part's centre, from which `to_origin_m` leads to the object's
/// origin.
template <int N>
std::optional<Observation<N>> observe_point(const Eigen::Matrix<double, N, 1>& measured_px,
                                            const Eigen::Vector3d& to_origin_m, double sigma_px, double extent_sigma_m,
                                            const StereoGeometry& geometry, const Se3& T_world_cam,
                                            const Vector6d& state) {
  const Se3 T_cam_world = T_world_cam.inverse();
  const Eigen::Vector3d p_cam = T_cam_world * (state.head<3>() - to_origin_m);
  if (!(p_cam.z() > kMinProjectionDepth_m)) {
    return std::nullopt;
  }
  const Projection predicted = project(geometry, p_cam);
  const Eigen::Matrix<double, N, 3> per_metre = predicted.jacobian.topRows<N>() * T_cam_world.rotation;
  Observation<N> out;
  out.residual = measured_px - predicted.uvd_px.head<N>();
  out.jacobian << per_metre, Eigen::Matrix<double, N, 3>::Zero();
  out.noise = sigma_px * sigma_px * Eigen::Matrix<double, N, N>::Identity() +
              extent_sigma_m * extent_sigma_m * per_metre * per_metre.transpose();
  return out;
}

std::optional<Observation<3>> observe(const StereoPosition& measured, double sigma_px, const StereoGeometry& geometry,
                                      const Se3& T_world_cam, const Vector6d& state) {
  return observe_point<3>(measured.uvd_px, measured.to_origin_m, median_sigma_px(sigma_px, measured.features),
                          measured.extent_sigma_m, geometry, T_world_cam, state);
}

std::optional<Observation<2>> observe(const Bearing& measured, double sigma_px, const StereoGeometry& geometry,
                                      const Se3& T_world_cam, const Vector6d& state) {
  return observe_point<2>(measured.uv_px, measured.to_origin_m, sigma_px, measured.extent_sigma_m, geometry,
                          T_world_cam, state);
}

// The point is on its measured ray, at the depth of the visible part; the velocity gives its previous position.
std::optional<Observation<2>> observe(const ImageMotion& measured, double sigma_px, const StereoGeometry& geometry,
                                      const Se3& T_world_cam, const Vector6d& state) {
  const double depth_m = (T_world_cam.inverse() * Eigen::Vector3d(state.head<3>() - measured.to_origin_m)).z();
  const Eigen::Vector3d ray((measured.now_px.x() - geometry.cx_px) / geometry.fx_px,
                            (measured.now_px.y() - geometry.cy_px) / geometry.fy_px, 1.0);
  const Eigen::Vector3d now_m = T_world_cam * Eigen::Vector3d(depth_m * ray);
  const Eigen::Vector3d before_m =
      measured.T_world_cam_before.inverse() * (now_m - measured.interval_s * state.tail<3>());
  if (!(depth_m > kMinProjectionDepth_m) || !(before_m.z() > kMinProjectionDepth_m)) {
    return std::nullopt;
  }
  const Projection predicted = project(geometry, before_m);
  const Eigen::Matrix<double, 2, 3> per_metre =
      predicted.jacobian.topRows<2>() * measured.T_world_cam_before.rotation.transpose();
  Observation<2> out;
  out.residual = measured.before_px - predicted.uvd_px.head<2>();
  out.jacobian << per_metre * T_world_cam.rotation * ray * T_world_cam.rotation.col(2).transpose(),
      -measured.interval_s * per_metre;
  const double of_median_px = median_sigma_px(sigma_px, measured.features);
  out.noise = of_median_px * of_median_px * Eigen::Matrix2d::Identity();
  return out;
}

/// Normalised innovation squared, and the log density of the innovation up to a constant.
struct Innovation {
  double nis = 0.0;
  double log_density = 0.0;
};

template <int N>
Innovation innovation_of(const Observation<N>& observation, const Matrix6d& covariance) {
  const Eigen::LDLT<Eigen::Matrix<double, N, N>> innovation_covariance(
      observation.jacobian * covariance * observation.jacobian.transpose() + observation.noise);
  Innovation out;
  out.nis = observation.residual.dot(innovation_covariance.solve(observation.residual));
  out.log_density = -0.5 * (out.nis + innovation_covariance.vectorD().array().log().sum());
  return out;
}

}  // namespace

void MotionFilter::start(const MotionStart& start) noexcept {
  initialised_ = true;
  timestamp_ns_ = start.timestamp_ns;
  start_timestamp_ns_ = start.timestamp_ns;
  interval_s_ = 0.0;
  start_rotation_covariance_ = start.pose.covariance.topLeftCorner<3, 3>();
  turn_rate_radps_ = start.velocity.head<3>();
  for (Model& model : model_) {
    model.pose = start.pose.T_world_obj;
    model.covariance.setZero();
    model.covariance.topLeftCorner<3, 3>() = start.pose.covariance.bottomRightCorner<3, 3>();
  }
  model_[kStationary].velocity_mps.setZero();
  model_[kStationary].covariance.diagonal().tail<3>().setConstant(kRestSpeedSigma_mps * kRestSpeedSigma_mps);
  model_[kStationary].probability = 1.0 - start.moving_probability;
  const Eigen::Matrix3d prior_covariance =
      kVelocityPriorSigma_mps * kVelocityPriorSigma_mps * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d gain = prior_covariance * (prior_covariance + start.velocity_covariance).inverse();
  const double lag_mps = noise_.acceleration_mps2 * kVelocityLag_s;
  model_[kMoving].velocity_mps = gain * (start.pose.T_world_obj.rotation * start.velocity.tail<3>());
  model_[kMoving].covariance.bottomRightCorner<3, 3>() =
      gain * start.velocity_covariance + lag_mps * lag_mps * Eigen::Matrix3d::Identity();
  model_[kMoving].probability = start.moving_probability;
}

void MotionFilter::restart_at(const StereoPosition& measured, const Se3& T_world_cam) noexcept {
  const Eigen::Vector3d p_cam = geometry_.triangulate(measured.uvd_px.x(), measured.uvd_px.y(), measured.uvd_px.z());
  const Eigen::Matrix3d per_pixel = T_world_cam.rotation * project(geometry_, p_cam).jacobian.inverse();
  const double of_median_px = median_sigma_px(noise_.stereo_sigma_px, measured.features);
  MotionStart from{.timestamp_ns = timestamp_ns_, .pose = {pose(), pose_covariance()}};
  from.pose.T_world_obj.translation = T_world_cam * p_cam + measured.to_origin_m;
  from.pose.covariance.bottomRightCorner<3, 3>() =
      of_median_px * of_median_px * per_pixel * per_pixel.transpose() +
      measured.extent_sigma_m * measured.extent_sigma_m * Eigen::Matrix3d::Identity();
  from.velocity_covariance = kUnknownVelocitySigma_mps * kUnknownVelocitySigma_mps * Eigen::Matrix3d::Identity();
  start(from);
}

// IMM mixing: each model continues from both posteriors, weighted by the transition probabilities.
MotionFilter::Models MotionFilter::mix(double interval_s) const noexcept {
  const auto stay_probability = [&](std::size_t model) { return std::exp(-interval_s / kDwell_s[model]); };
  Models out;
  for (std::size_t to = 0; to < model_.size(); ++to) {
    const std::size_t from = 1 - to;
    const Model& same = model_[to];
    const Model& other = model_[from];
    const double of_same = stay_probability(to) * same.probability;
    const double of_other = (1.0 - stay_probability(from)) * other.probability;
    Model& result = out[to];
    result.probability = of_same + of_other;
    const double weight = of_other / result.probability;
    result.pose = weight < 0.5 ? same.pose : other.pose;
    result.pose.translation = (1.0 - weight) * same.pose.translation + weight * other.pose.translation;
    result.velocity_mps = (1.0 - weight) * same.velocity_mps + weight * other.velocity_mps;
    Vector6d between;
    between << other.pose.translation - same.pose.translation, other.velocity_mps - same.velocity_mps;
    result.covariance = (1.0 - weight) * same.covariance + weight * other.covariance +
                        weight * (1.0 - weight) * between * between.transpose();
  }
  return out;
}

void MotionFilter::propagate(Models& models, double interval_s) const noexcept {
  Model& moving = models[kMoving];
  const Eigen::Matrix3d rotation = moving.pose.rotation * so3_exp(interval_s * turn_rate_radps_);
  const Eigen::Matrix3d turn = rotation * moving.pose.rotation.transpose();
  const Eigen::Vector3d velocity_mps = turn * moving.velocity_mps;
  moving.pose = {orthonormalised(rotation), moving.pose.translation + interval_s * moving.velocity_mps};
  moving.velocity_mps = velocity_mps;
  Matrix6d transition = Matrix6d::Identity();
  transition.topRightCorner<3, 3>().diagonal().setConstant(interval_s);
  transition.bottomRightCorner<3, 3>() = turn;
  const double density = noise_.acceleration_mps2 * noise_.acceleration_mps2 * kAccelerationTime_s;
  const Eigen::Matrix3d unit = density * interval_s * Eigen::Matrix3d::Identity();
  Matrix6d noise;
  noise << interval_s * interval_s / 3.0 * unit, 0.5 * interval_s * unit, 0.5 * interval_s * unit, unit;
  moving.covariance = transition * moving.covariance * transition.transpose() + noise;

  Model& stationary = models[kStationary];
  stationary.velocity_mps.setZero();
  const Eigen::Matrix3d position_covariance = stationary.covariance.topLeftCorner<3, 3>();
  stationary.covariance.setZero();
  stationary.covariance.topLeftCorner<3, 3>() =
      position_covariance + kRestDrift_m * kRestDrift_m * interval_s * Eigen::Matrix3d::Identity();
  stationary.covariance.diagonal().tail<3>().setConstant(kRestSpeedSigma_mps * kRestSpeedSigma_mps);
}

void MotionFilter::predict(std::int64_t timestamp_ns) noexcept {
  const double interval_s = 1e-9 * static_cast<double>(timestamp_ns - timestamp_ns_);
  if (!initialised_ || interval_s <= 0.0) {
    return;
  }
  timestamp_ns_ = timestamp_ns;
  interval_s_ = interval_s;
  model_ = mix(interval_s);
  propagate(model_, interval_s);
}

UncertainPose MotionFilter::predicted(std::int64_t timestamp_ns) const noexcept {
  Models models = model_;
  propagate(models, std::max(1e-9 * static_cast<double>(timestamp_ns - timestamp_ns_), 0.0));
  const Model& model = models[at_rest() ? kStationary : kMoving];
  return {model.pose, pose_covariance(model, timestamp_ns)};
}

Matrix6d MotionFilter::pose_covariance(const Model& model, std::int64_t timestamp_ns) const noexcept {
  const double unseen_s = 1e-9 * static_cast<double>(timestamp_ns - start_timestamp_ns_);
  const double turn_rad = noise_.turn_radps2 * unseen_s * (0.5 * unseen_s + kVelocityLag_s);
  Matrix6d covariance = Matrix6d::Zero();
  covariance.topLeftCorner<3, 3>() = start_rotation_covariance_ + turn_rad * turn_rad * Eigen::Matrix3d::Identity();
  covariance.bottomRightCorner<3, 3>() = model.covariance.topLeftCorner<3, 3>();
  return covariance;
}

// Iterated: relinearised at each corrected state.
template <typename Linearised, typename Observe>
void MotionFilter::correct(Model& model, Linearised observation, double noise_factor, const Observe& observed_at) {
  Vector6d before;
  before << model.pose.translation, model.velocity_mps;
  Eigen::Matrix<double, 6, decltype(observation.jacobian)::RowsAtCompileTime> gain;
  Vector6d correction = Vector6d::Zero();
  for (int i = 0; i < kIterations; ++i) {
    if (i > 0) {
      const auto next = observed_at(before + correction);
      if (!next) {
        break;
      }
      observation = *next;
    }
    observation.noise *= noise_factor;
    const auto innovation_covariance =
        (observation.jacobian * model.covariance * observation.jacobian.transpose() + observation.noise).eval();
    gain = innovation_covariance.ldlt().solve(observation.jacobian * model.covariance).transpose();
    correction = gain * (observation.residual + observation.jacobian * correction);
  }
  // Joseph's form stays symmetric and positive semidefinite.
  const Matrix6d i_minus_kh = Matrix6d::Identity() - gain * observation.jacobian;
  model.covariance =
      i_minus_kh * model.covariance * i_minus_kh.transpose() + gain * observation.noise * gain.transpose();
  model.pose.translation += correction.head<3>();
  model.velocity_mps += correction.tail<3>();
}

template <typename Measurement>
bool MotionFilter::update_models(const Measurement& measured, const Se3& T_world_cam, double gate) noexcept {
  const auto observed_at = [&](const Vector6d& state) {
    return observe(measured, noise_.stereo_sigma_px, geometry_, T_world_cam, state);
  };
  // Measurements within the correlation time of their errors count once for the model probabilities.
  const double weight = std::min(interval_s_ / kErrorCorrelation_s, 1.0);
  std::array<double, 2> log_density{};
  std::array<bool, 2> passes_gate{};
  for (std::size_t m = 0; m < model_.size(); ++m) {
    Model& model = model_[m];
    Vector6d before;
    before << model.pose.translation, model.velocity_mps;
    log_density[m] = -std::numeric_limits<double>::infinity();
    const auto observation = observed_at(before);
    if (!observation) {
      continue;
    }
    const Innovation innovation = innovation_of(*observation, model.covariance);
    log_density[m] = innovation.log_density;
    passes_gate[m] = innovation.nis <= gate;
    if (!passes_gate[m]) {
      continue;
    }
    // An object at rest shows the same side with the same error: one independent position per correlation time.
    const double noise_factor = m == kStationary && weight > 0.0 ? 1.0 / weight : 1.0;
    correct(model, *observation, noise_factor, observed_at);
  }
  if (!passes_gate[kStationary] && !passes_gate[kMoving]) {
    return false;
  }
  const double best = std::max(log_density[0], log_density[1]);
  double sum = 0.0;
  for (std::size_t m = 0; m < model_.size(); ++m) {
    model_[m].probability =
        std::max(model_[m].probability * std::exp(weight * (log_density[m] - best)), kMinProbability);
    sum += model_[m].probability;
  }
  for (Model& model : model_) {
    model.probability /= sum;
  }
  return true;
}

bool MotionFilter::update(const StereoPosition& measured, const Se3& T_world_cam) noexcept {
  return initialised_ && is_measured(measured) && update_models(measured, T_world_cam, kChiSquareGate3);
}

bool MotionFilter::update(const Bearing& measured, const Se3& T_world_cam) noexcept {
  return initialised_ && measured.uv_px.allFinite() && update_models(measured, T_world_cam, kNoGate);
}

bool MotionFilter::update(const ImageMotion& measured, const Se3& T_world_cam) noexcept {
  return initialised_ && measured.features > 0 && measured.interval_s > 0.0 &&
         update_models(measured, T_world_cam, kChiSquareGate2);
}

std::optional<double> MotionFilter::log_likelihood(const StereoPosition& measured, double body_volume_px3,
                                                   const Se3& T_world_cam) const noexcept {
  std::array<double, 2> log_density{};
  log_density.fill(-std::numeric_limits<double>::infinity());
  for (std::size_t m = 0; m < model_.size(); ++m) {
    Vector6d state;
    state << model_[m].pose.translation, model_[m].velocity_mps;
    const auto observation = observe(measured, noise_.stereo_sigma_px, geometry_, T_world_cam, state);
    if (initialised_ && is_measured(measured) && observation) {
      const Innovation innovation = innovation_of(*observation, model_[m].covariance);
      const double innovation_volume_px3 =
          std::pow(2.0 * std::numbers::pi, 1.5) * std::exp(-innovation.log_density - 0.5 * innovation.nis);
      log_density[m] =
          std::log(model_[m].probability) - 0.5 * innovation.nis - std::log(body_volume_px3 + innovation_volume_px3);
    }
  }
  const double best = std::max(log_density[0], log_density[1]);
  if (!std::isfinite(best)) {
    return std::nullopt;
  }
  return best + std::log(std::exp(log_density[0] - best) + std::exp(log_density[1] - best));
}

bool MotionFilter::accepts(const StereoPosition& measured, const Se3& T_world_cam) const noexcept {
  return initialised_ && is_measured(measured) && std::any_of(model_.begin(), model_.end(), [&](const Model& model) {
           Vector6d state;
           state << model.pose.translation, model.velocity_mps;
           const auto observation = observe(measured, noise_.stereo_sigma_px, geometry_, T_world_cam, state);
           return observation && innovation_of(*observation, model.covariance).nis <= kChiSquareGate3;
         });
}

}  // namespace kinetrace::objects

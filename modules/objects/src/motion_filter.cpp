#include "kinetrace/objects/motion_filter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "kinetrace/core/body_velocity.hpp"
#include "kinetrace/core/quantiles.hpp"

namespace kinetrace::objects {
namespace {

/// Apparent drift of an object at rest in one second: errors of the camera's path and of the masks.
constexpr double kRestDrift_m = 0.02;
/// Mean dwell times: at rest, mostly parked, and moving, until a stop in traffic.
constexpr std::array kDwell_s{200.0, 20.0};
/// A fitted velocity is that of the middle of its path, this long ago.
constexpr double kVelocityLag_s = 0.3;
constexpr double kNoGate = std::numeric_limits<double>::infinity();
constexpr int kIterations = 3;
/// Errors of the points of one object are correlated: more features do not improve their median.
constexpr int kMaxIndependentFeatures = 4;
constexpr double kMinProbability = 1e-6;
/// Prior standard deviation of velocities on streets; a measured velocity less certain than this is mostly noise.
constexpr double kVelocityPriorSigma_mps = 20.0;

/// A measurement of N numbers at a state: residual, Jacobian by the state, covariance of its noise.
template <int N>
struct Observation {
  Eigen::Matrix<double, N, 1> residual;
  Eigen::Matrix<double, N, MotionFilter::kStates> jacobian;
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

/// The first N of (u_left, v, disparity) of the visible part's centre.
template <int N>
std::optional<Observation<N>> observe_part(const Eigen::Matrix<double, N, 1>& measured_px, const VisiblePart& part,
                                           double sigma_px, const StereoGeometry& geometry, const Se3& T_world_cam,
                                           const MotionFilter::State& state) {
  const Se3 T_cam_world = T_world_cam.inverse();
  const Eigen::Vector3d p_cam = T_cam_world * (state.head<3>() - part.to_origin_m + state.tail<3>());
  if (!(p_cam.z() > kMinProjectionDepth_m)) {
    return std::nullopt;
  }
  const Projection predicted = project(geometry, p_cam);
  const Eigen::Matrix<double, N, 3> per_metre = predicted.jacobian.topRows<N>() * T_cam_world.rotation;
  Observation<N> out;
  out.residual = measured_px - predicted.uvd_px.head<N>();
  out.jacobian << per_metre, Eigen::Matrix<double, N, 3>::Zero(), per_metre;
  out.noise = sigma_px * sigma_px * Eigen::Matrix<double, N, N>::Identity();
  return out;
}

std::optional<Observation<3>> observe(const StereoPosition& measured, double sigma_px, const StereoGeometry& geometry,
                                      const Se3& T_world_cam, const MotionFilter::State& state) {
  return observe_part<3>(measured.uvd_px, measured.part, median_sigma_px(sigma_px, measured.features), geometry,
                         T_world_cam, state);
}

std::optional<Observation<2>> observe(const Bearing& measured, double sigma_px, const StereoGeometry& geometry,
                                      const Se3& T_world_cam, const MotionFilter::State& state) {
  std::optional<Observation<2>> out =
      observe_part<2>(measured.uv_px, measured.part, sigma_px, geometry, T_world_cam, state);
  if (out) {
    const Eigen::Matrix<double, 2, 3> per_metre = out->jacobian.leftCols<3>();
    out->noise += measured.center_sigma_m * measured.center_sigma_m * per_metre * per_metre.transpose();
  }
  return out;
}

// The point is on its measured ray, at the depth of the visible part; the velocity gives its previous position.
std::optional<Observation<2>> observe(const ImageMotion& measured, double sigma_px, const StereoGeometry& geometry,
                                      const Se3& T_world_cam, const MotionFilter::State& state) {
  const double depth_m = (T_world_cam.inverse() * Eigen::Vector3d(state.head<3>() - measured.to_origin_m)).z();
  const Eigen::Vector3d ray((measured.now_px.x() - geometry.cx_px) / geometry.fx_px,
                            (measured.now_px.y() - geometry.cy_px) / geometry.fy_px, 1.0);
  const Eigen::Vector3d now_m = T_world_cam * Eigen::Vector3d(depth_m * ray);
  const Eigen::Vector3d before_m =
      measured.T_world_cam_before.inverse() * (now_m - measured.interval_s * state.segment<3>(3));
  if (!(depth_m > kMinProjectionDepth_m) || !(before_m.z() > kMinProjectionDepth_m)) {
    return std::nullopt;
  }
  const Projection predicted = project(geometry, before_m);
  const Eigen::Matrix<double, 2, 3> per_metre =
      predicted.jacobian.topRows<2>() * measured.T_world_cam_before.rotation.transpose();
  Observation<2> out;
  out.residual = measured.before_px - predicted.uvd_px.head<2>();
  out.jacobian << per_metre * T_world_cam.rotation * ray * T_world_cam.rotation.col(2).transpose(),
      -measured.interval_s * per_metre, Eigen::Matrix<double, 2, 3>::Zero();
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
Innovation innovation_of(const Observation<N>& observation, const MotionFilter::StateCovariance& covariance) {
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
  part_covariance_m2_ = start.part_covariance_m2;
  for (Model& model : model_) {
    model.rotation = start.pose.T_world_obj.rotation;
    model.state << start.pose.T_world_obj.translation, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero();
    model.covariance.setZero();
    model.covariance.topLeftCorner<3, 3>() = start.pose.covariance.bottomRightCorner<3, 3>();
  }
  model_[kStationary].covariance.diagonal().segment<3>(3).setConstant(kRestSpeedSigma_mps * kRestSpeedSigma_mps);
  model_[kStationary].probability = 1.0 - start.moving_probability;
  const Eigen::Matrix3d prior_covariance = noise_.prior.velocity_covariance(vertical_, kVelocityPriorSigma_mps);
  const Eigen::Matrix3d gain = prior_covariance * (prior_covariance + start.velocity_covariance).inverse();
  model_[kMoving].state.segment<3>(3) = gain * (start.pose.T_world_obj.rotation * start.velocity.tail<3>());
  model_[kMoving].covariance.block<3, 3>(3, 3) =
      gain * start.velocity_covariance +
      kVelocityLag_s * kVelocityLag_s * noise_.prior.acceleration_covariance(vertical_);
  model_[kMoving].probability = start.moving_probability;
}

void MotionFilter::restart_at(const StereoPosition& measured, const Se3& T_world_cam) noexcept {
  const Eigen::Vector3d p_cam = geometry_.triangulate(measured.uvd_px.x(), measured.uvd_px.y(), measured.uvd_px.z());
  const Eigen::Matrix3d per_pixel = T_world_cam.rotation * project(geometry_, p_cam).jacobian.inverse();
  const double of_median_px = median_sigma_px(noise_.stereo_sigma_px, measured.features);
  MotionStart from{.timestamp_ns = timestamp_ns_,
                   .pose = {pose(), pose_covariance()},
                   .part_covariance_m2 = measured.part.covariance_m2};
  from.pose.T_world_obj.translation = T_world_cam * p_cam + measured.part.to_origin_m;
  from.pose.covariance.bottomRightCorner<3, 3>() = of_median_px * of_median_px * per_pixel * per_pixel.transpose();
  from.velocity_covariance = kUnknownVelocitySigma_mps * kUnknownVelocitySigma_mps * Eigen::Matrix3d::Identity();
  start(from);
}

double MotionFilter::rest_likelihood(double interval_s) const noexcept {
  const Model& moving = model_[kMoving];
  const Eigen::Vector3d velocity_mps = moving.state.segment<3>(3);
  const Eigen::Matrix3d covariance =
      moving.covariance.block<3, 3>(3, 3) +
      kAccelerationTime_s * interval_s * noise_.prior.acceleration_covariance(vertical_) +
      kRestSpeedSigma_mps * kRestSpeedSigma_mps * Eigen::Matrix3d::Identity();
  return std::exp(-0.5 * velocity_mps.dot(covariance.ldlt().solve(velocity_mps)));
}

// IMM mixing: each model continues from both posteriors, weighted by the transition probabilities. An object comes to
// rest only from a low speed; what is at rest all at once is another one.
MotionFilter::Models MotionFilter::mix(double interval_s) const noexcept {
  const auto leave_probability = [&](std::size_t model) { return 1.0 - std::exp(-interval_s / kDwell_s[model]); };
  const std::array leaves{leave_probability(kStationary), leave_probability(kMoving) * rest_likelihood(interval_s)};
  Models out;
  for (std::size_t to = 0; to < model_.size(); ++to) {
    const std::size_t from = 1 - to;
    const Model& same = model_[to];
    const Model& other = model_[from];
    const double of_same = (1.0 - leaves[to]) * same.probability;
    const double of_other = leaves[from] * other.probability;
    Model& result = out[to];
    result.probability = of_same + of_other;
    const double weight = of_other / result.probability;
    result.rotation = weight < 0.5 ? same.rotation : other.rotation;
    result.state = (1.0 - weight) * same.state + weight * other.state;
    const State between = other.state - same.state;
    result.covariance = (1.0 - weight) * same.covariance + weight * other.covariance +
                        weight * (1.0 - weight) * between * between.transpose();
  }
  return out;
}

void MotionFilter::propagate(Models& models, double interval_s) const noexcept {
  const double part_stays = std::exp(-interval_s / kErrorCorrelation_s);
  Model& moving = models[kMoving];
  const Eigen::Matrix3d rotation = moving.rotation * so3_exp(interval_s * turn_rate_radps_);
  StateCovariance transition = StateCovariance::Identity();
  transition.block<3, 3>(0, 3).diagonal().setConstant(interval_s);
  transition.block<3, 3>(3, 3) = rotation * moving.rotation.transpose();
  transition.bottomRightCorner<3, 3>() *= part_stays;
  moving.rotation = orthonormalised(rotation);
  moving.state = transition * moving.state;
  const Eigen::Matrix3d unit = kAccelerationTime_s * interval_s * noise_.prior.acceleration_covariance(vertical_);
  Matrix6d noise;
  noise << interval_s * interval_s / 3.0 * unit, 0.5 * interval_s * unit, 0.5 * interval_s * unit, unit;
  moving.covariance = transition * moving.covariance * transition.transpose();
  moving.covariance.topLeftCorner<6, 6>() += noise;

  Model& stationary = models[kStationary];
  StateCovariance rest = StateCovariance::Identity();
  rest.block<3, 3>(3, 3).setZero();
  rest.bottomRightCorner<3, 3>() *= part_stays;
  stationary.state = rest * stationary.state;
  stationary.covariance = rest * stationary.covariance * rest.transpose();
  stationary.covariance.diagonal().head<3>().array() += kRestDrift_m * kRestDrift_m * interval_s;
  stationary.covariance.diagonal().segment<3>(3).setConstant(kRestSpeedSigma_mps * kRestSpeedSigma_mps);
  for (Model& model : models) {
    model.covariance.bottomRightCorner<3, 3>() += (1.0 - part_stays * part_stays) * part_covariance_m2_;
  }
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

MotionFilter::Models MotionFilter::predicted_models(std::int64_t timestamp_ns) const noexcept {
  Models models = model_;
  propagate(models, std::max(1e-9 * static_cast<double>(timestamp_ns - timestamp_ns_), 0.0));
  return models;
}

MotionFilter::Models MotionFilter::with_part(Models models, const VisiblePart& part) const noexcept {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> growth(part.covariance_m2 - part_covariance_m2_);
  const Eigen::Matrix3d added_m2 =
      growth.eigenvectors() * growth.eigenvalues().cwiseMax(0.0).asDiagonal() * growth.eigenvectors().transpose();
  for (Model& model : models) {
    model.covariance.bottomRightCorner<3, 3>() += added_m2;
  }
  return models;
}

UncertainPose MotionFilter::predicted(std::int64_t timestamp_ns) const noexcept {
  const Model model = predicted_models(timestamp_ns)[likelier()];
  return {model.pose(), pose_covariance(model, timestamp_ns)};
}

UncertainPosition MotionFilter::predicted_part(std::int64_t timestamp_ns, const VisiblePart& part) const noexcept {
  const Model model = with_part(predicted_models(timestamp_ns), part)[likelier()];
  Eigen::Matrix<double, 3, kStates> by_state;
  by_state << Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Identity();
  return {by_state * model.state - part.to_origin_m, by_state * model.covariance * by_state.transpose()};
}

Matrix6d MotionFilter::pose_covariance(const Model& model, std::int64_t timestamp_ns) const noexcept {
  const double unseen_s = 1e-9 * static_cast<double>(timestamp_ns - start_timestamp_ns_);
  const double per_acceleration_s2 = unseen_s * (0.5 * unseen_s + kVelocityLag_s);
  Matrix6d covariance = Matrix6d::Zero();
  covariance.topLeftCorner<3, 3>() =
      start_rotation_covariance_ + per_acceleration_s2 * per_acceleration_s2 * noise_.prior.turn_covariance(vertical_);
  covariance.bottomRightCorner<3, 3>() = model.covariance.topLeftCorner<3, 3>();
  return covariance;
}

// Iterated: relinearised at each corrected state.
template <typename Linearised, typename Observe>
void MotionFilter::correct(Model& model, Linearised observation, const Observe& observed_at) {
  const State before = model.state;
  Eigen::Matrix<double, kStates, decltype(observation.jacobian)::RowsAtCompileTime> gain;
  State correction = State::Zero();
  for (int i = 0; i < kIterations; ++i) {
    if (i > 0) {
      const auto next = observed_at(before + correction);
      if (!next) {
        break;
      }
      observation = *next;
    }
    const auto innovation_covariance =
        (observation.jacobian * model.covariance * observation.jacobian.transpose() + observation.noise).eval();
    gain = innovation_covariance.ldlt().solve(observation.jacobian * model.covariance).transpose();
    correction = gain * (observation.residual + observation.jacobian * correction);
  }
  // Joseph's form stays symmetric and positive semidefinite.
  const StateCovariance i_minus_kh = StateCovariance::Identity() - gain * observation.jacobian;
  model.covariance =
      i_minus_kh * model.covariance * i_minus_kh.transpose() + gain * observation.noise * gain.transpose();
  model.state += correction;
}

template <typename Measurement>
bool MotionFilter::update_models(const Measurement& measured, const Se3& T_world_cam, double gate) noexcept {
  const auto observed_at = [&](const State& state) {
    return observe(measured, noise_.stereo_sigma_px, geometry_, T_world_cam, state);
  };
  // Measurements within the correlation time of their errors count once for the model probabilities.
  const double weight = std::min(interval_s_ / kErrorCorrelation_s, 1.0);
  std::array<double, std::tuple_size_v<Models>> log_density{};
  std::array<bool, std::tuple_size_v<Models>> passes_gate{};
  for (std::size_t m = 0; m < model_.size(); ++m) {
    Model& model = model_[m];
    log_density[m] = -std::numeric_limits<double>::infinity();
    const auto observation = observed_at(model.state);
    if (!observation) {
      continue;
    }
    const Innovation innovation = innovation_of(*observation, model.covariance);
    log_density[m] = innovation.log_density;
    passes_gate[m] = innovation.nis <= gate;
    if (!passes_gate[m]) {
      continue;
    }
    correct(model, *observation, observed_at);
  }
  if (std::none_of(passes_gate.begin(), passes_gate.end(), [](bool passes) { return passes; })) {
    return false;
  }
  const double best = *std::max_element(log_density.begin(), log_density.end());
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

void MotionFilter::set_part(const VisiblePart& part) noexcept {
  model_ = with_part(model_, part);
  part_covariance_m2_ = part.covariance_m2;
}

bool MotionFilter::update(const StereoPosition& measured, const Se3& T_world_cam) noexcept {
  if (!initialised_ || !is_measured(measured)) {
    return false;
  }
  set_part(measured.part);
  return update_models(measured, T_world_cam, kChiSquareGate3);
}

bool MotionFilter::update(const Bearing& measured, const Se3& T_world_cam) noexcept {
  if (!initialised_ || !measured.uv_px.allFinite()) {
    return false;
  }
  set_part(measured.part);
  return update_models(measured, T_world_cam, kNoGate);
}

bool MotionFilter::update(const ImageMotion& measured, const Se3& T_world_cam) noexcept {
  return initialised_ && measured.features > 0 && measured.interval_s > 0.0 &&
         update_models(measured, T_world_cam, kChiSquareGate2);
}

std::optional<double> MotionFilter::log_likelihood(const StereoPosition& measured,
                                                   const Se3& T_world_cam) const noexcept {
  const Models models = with_part(model_, measured.part);
  std::array<double, std::tuple_size_v<Models>> log_density{};
  log_density.fill(-std::numeric_limits<double>::infinity());
  for (std::size_t m = 0; m < models.size(); ++m) {
    const auto observation = observe(measured, noise_.stereo_sigma_px, geometry_, T_world_cam, models[m].state);
    if (initialised_ && is_measured(measured) && observation) {
      const Innovation innovation = innovation_of(*observation, models[m].covariance);
      log_density[m] =
          std::log(models[m].probability) + innovation.log_density - 1.5 * std::log(2.0 * std::numbers::pi);
    }
  }
  const double best = *std::max_element(log_density.begin(), log_density.end());
  if (!std::isfinite(best)) {
    return std::nullopt;
  }
  double sum = 0.0;
  for (const double each : log_density) {
    sum += std::exp(each - best);
  }
  return best + std::log(sum);
}

}  // namespace kinetrace::objects

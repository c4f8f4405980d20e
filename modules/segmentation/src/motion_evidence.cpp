#include "kinetrace/segmentation/motion_evidence.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "kinetrace/core/quantiles.hpp"
#include "patch_similarity.hpp"
#include "velocity_test.hpp"

namespace kinetrace::segmentation {
namespace {

/// Mean NIS over its expectation, beyond which no constant velocity fits.
constexpr double kMaxNisRatio = 3.0;
/// One observation in four may be an outlier.
constexpr int kMaxOutlierRatio = 3;
/// Prior standard deviation of a velocity, m/s.
constexpr double kPriorSpeedMps = 30.0;
/// Spectral density of the acceleration over the squared speed, 1/s: turns of .5 rad/s and more, or braking as hard.
constexpr double kTurnNoise = 0.5;
/// Below this significance of motion, repetitive texture is no concern.
constexpr float kMovingChi2 = 16.F;
/// Patches nearer to each other share most of their pixels and always look alike.
constexpr float kMinJumpPx = 6.F;
/// Correlation of two patches from which a tracker may confuse them.
constexpr float kSamePatch = 0.75F;

}  // namespace

MotionEvidence::MotionEvidence(const MotionConfig& config, const StereoGeometry& geometry, int max_features,
                               Arena& arena)
    : config_(config),
      geometry_(geometry),
      slots_(arena.take<Slot>(static_cast<std::size_t>(max_features))),
      motions_(arena, static_cast<std::size_t>(max_features)) {}

void MotionEvidence::reset() noexcept {
  for (Slot& slot : slots_) {
    slot.feature_id = 0;
  }
  started_ = false;
  T_world_cam_ = {};
  T_world_prev_ = {};
  ego_speed_mps_ = 0.0;
}

std::span<const FeatureMotion> MotionEvidence::update(std::span<const Feature> features, GrayView left,
                                                      const Se3& T_prev_cam, std::int64_t timestamp_ns) {
  T_world_prev_ = T_world_cam_;
  before_ns_ = now_ns_;
  now_ns_ = timestamp_ns;
  if (started_) {
    T_world_cam_ = (T_world_cam_ * T_prev_cam).orthonormalised();
    interval_s_ = 1e-9 * static_cast<double>(now_ns_ - before_ns_);
    ego_speed_mps_ = interval_s_ > 0.0 ? T_prev_cam.translation.norm() / interval_s_ : 0.0;
  }
  motions_.clear();
  for (const Feature& feature : features) {
    FeatureMotion motion;
    if (feature.slot < slots_.size() && feature.has_right() && feature.disparity_px() >= config_.min_disparity_px) {
      Slot& slot = slots_[feature.slot];
      observe(feature, slot);
      motion = motion_of(feature, slot);
      motion.known = motion.known && !looks_the_same_at_rest(feature, motion, left);
    }
    (void)motions_.push_back(motion);  // beyond max_features the rest is ignored
  }
  started_ = true;
  return motions_.span();
}

void MotionEvidence::observe(const Feature& feature, Slot& slot) const {
  const Eigen::Vector3d observation(feature.left_px.x(), feature.v_px, feature.u_right_px);
  if (slot.feature_id != feature.id) {
    // A feature new to this filter may already have been matched in the previous frame.
    const double previous_px = feature.previous_left_px.x() - feature.previous_u_right_px;
    const bool seen_before =
        started_ && feature.age_frames > 0 && previous_px >= config_.min_disparity_px;  // false without a match
    if (!seen_before) {
      begin(slot, feature, observation, T_world_cam_, now_ns_);
      return;
    }
    begin(slot, feature, {feature.previous_left_px.x(), feature.previous_v_px, feature.previous_u_right_px},
          T_world_prev_, before_ns_);
  }
  predict(slot, now_ns_);
  correct(slot, observation, T_world_cam_);
  if (slot.successive_outliers > 1) {
    begin(slot, feature, observation, T_world_cam_, now_ns_);
  }
}

Eigen::Matrix3d MotionEvidence::projection_jacobian(const Eigen::Vector3d& p_cam) const {
  const double inv_z = 1.0 / p_cam.z();
  const double x = p_cam.x() * inv_z;
  Eigen::Matrix3d jacobian;
  jacobian << geometry_.fx_px, 0.0, -geometry_.fx_px * x,          //
      0.0, geometry_.fy_px, -geometry_.fy_px * p_cam.y() * inv_z,  //
      geometry_.fx_px, 0.0, -geometry_.fx_px * x + geometry_.fx_px * geometry_.baseline_m * inv_z;
  return jacobian * inv_z;
}

void MotionEvidence::begin(Slot& slot, const Feature& feature, const Eigen::Vector3d& observation,
                           const Se3& T_world_cam, std::int64_t timestamp_ns) const {
  slot = {};
  slot.feature_id = feature.id;
  slot.observations = 1;
  slot.first_ns = timestamp_ns;
  slot.last_ns = timestamp_ns;
  const Eigen::Vector3d p_cam =
      geometry_.triangulate(observation.x(), observation.y(), observation.x() - observation.z());
  slot.anchor_m = T_world_cam * p_cam;
  const Eigen::Matrix3d to_point = T_world_cam.rotation * projection_jacobian(p_cam).inverse();
  slot.covariance.topLeftCorner<3, 3>() = config_.sigma_px * config_.sigma_px * to_point * to_point.transpose();
  slot.covariance.bottomRightCorner<3, 3>() = kPriorSpeedMps * kPriorSpeedMps * Eigen::Matrix3d::Identity();
}

// Nearly constant velocity: white accelerations that grow with the speed, as in turning and braking. The fading memory
// inflates all covariances alike.
void MotionEvidence::predict(Slot& slot, std::int64_t timestamp_ns) const {
  const double dt_s = 1e-9 * static_cast<double>(timestamp_ns - slot.last_ns);
  slot.last_ns = timestamp_ns;
  slot.state.head<3>() += dt_s * slot.state.tail<3>();
  Matrix6& p = slot.covariance;
  const Eigen::Matrix3d cross = p.topRightCorner<3, 3>() + dt_s * p.bottomRightCorner<3, 3>();
  p.topLeftCorner<3, 3>() += dt_s * (p.topRightCorner<3, 3>().transpose() + cross);
  p.topRightCorner<3, 3>() = cross;
  p.bottomLeftCorner<3, 3>() = cross.transpose();
  p *= std::exp2(dt_s / config_.memory_s);
  const double speed_sq = std::max(0.0, slot.state.tail<3>().squaredNorm() - p.bottomRightCorner<3, 3>().trace());
  const double noise = kTurnNoise * speed_sq;
  p.topLeftCorner<3, 3>().diagonal().array() += noise * dt_s * dt_s * dt_s / 3.0;
  p.topRightCorner<3, 3>().diagonal().array() += noise * dt_s * dt_s / 2.0;
  p.bottomLeftCorner<3, 3>().diagonal().array() += noise * dt_s * dt_s / 2.0;
  p.bottomRightCorner<3, 3>().diagonal().array() += noise * dt_s;
}

void MotionEvidence::correct(Slot& slot, const Eigen::Vector3d& observation, const Se3& T_world_cam) const {
  const Eigen::Vector3d p_cam =
      T_world_cam.rotation.transpose() * (slot.anchor_m + slot.state.head<3>() - T_world_cam.translation);
  if (p_cam.z() < kMinProjectionDepth_m) {
    slot.successive_outliers = 2;
    return;
  }
  const Eigen::Matrix3d h = projection_jacobian(p_cam) * T_world_cam.rotation.transpose();
  const Eigen::Matrix<double, 6, 3> ph = slot.covariance.leftCols<3>() * h.transpose();
  Eigen::Matrix3d s = h * ph.topRows<3>();
  s.diagonal().array() += config_.sigma_px * config_.sigma_px;
  const Eigen::Matrix3d s_inverse = s.inverse();
  const Eigen::Vector3d innovation = observation - geometry_.project(p_cam);
  const double chi2 = innovation.dot(s_inverse * innovation);
  if (!(chi2 <= kChiSquareGate3)) {
    ++slot.successive_outliers;
    ++slot.outliers;
    return;
  }
  slot.successive_outliers = 0;
  ++slot.observations;
  const Eigen::Matrix<double, 6, 3> gain = ph * s_inverse;
  slot.state += gain * innovation;
  slot.covariance -= gain * ph.transpose();
  // The first innovation only initialises the velocity.
  if (slot.observations > 2) {
    const double weight = std::max(0.1, 1.0 / (slot.observations - 1));
    slot.nis_ratio += weight * (chi2 / 3.0 - slot.nis_ratio);
  }
}

FeatureMotion MotionEvidence::motion_of(const Feature& feature, const Slot& slot) const {
  FeatureMotion motion;
  motion.depth_m = static_cast<float>(geometry_.depth_m(feature.disparity_px()));
  // If the newest observation is an outlier, the feature is elsewhere.
  const double span_s = 1e-9 * static_cast<double>(slot.last_ns - slot.first_ns);
  if (slot.observations < 2 || slot.successive_outliers > 0 || kMaxOutlierRatio * slot.outliers > slot.observations ||
      slot.nis_ratio > kMaxNisRatio || span_s <= 0.0) {
    return motion;
  }
  motion.known = slot.observations >= 3;
  motion.fresh = !motion.known;
  const Eigen::Matrix3d covariance = std::max(1.0, slot.nis_ratio) * slot.covariance.bottomRightCorner<3, 3>();
  const Eigen::Matrix3d information = covariance.inverse();
  const Eigen::Vector3d velocity = slot.state.tail<3>();
  motion.velocity_mps = velocity.cast<float>();
  motion.information = information.cast<float>();
  motion.covariance = covariance.cast<float>();
  motion.static_chi2 = static_cast<float>(velocity.dot(information * velocity));
  motion.systematic = systematic_covariance(feature, std::min(span_s, config_.memory_s));
  return motion;
}

bool MotionEvidence::looks_the_same_at_rest(const Feature& feature, const FeatureMotion& motion, GrayView left) const {
  if (motion.static_chi2 < kMovingChi2 || left.empty()) {
    return false;
  }
  const Eigen::Vector3d p_cam =
      geometry_.triangulate(feature.left_px.x(), feature.left_px.y(), feature.disparity_px()) -
      T_world_cam_.rotation.transpose() * (interval_s_ * motion.velocity_mps.cast<double>());
  if (p_cam.z() <= 0.0) {
    return false;
  }
  const Eigen::Vector2f at_rest_px = geometry_.project(p_cam).head<2>().cast<float>();
  return (at_rest_px - feature.left_px).norm() >= kMinJumpPx &&
         patch_similarity(left, feature.left_px, at_rest_px) >= kSamePatch;
}

// Apparent common motion of a whole region: an error of the ego motion shifts its image, a bias of its disparity
// changes with the viewpoint.
Eigen::Matrix3f MotionEvidence::systematic_covariance(const Feature& feature, double span_s) const {
  const double d = feature.disparity_px();
  const double z = geometry_.depth_m(d);
  const double x = (feature.left_px.x() - geometry_.cx_px) / geometry_.fx_px;
  const double y = (feature.v_px - geometry_.cy_px) / geometry_.fy_px;
  const double lateral = config_.ego_sigma_px * z / geometry_.fx_px / span_s;
  const double radial = config_.bias_disparity_px * z / d / span_s;
  const Eigen::Vector3d ray = T_world_cam_.rotation * Eigen::Vector3d(x, y, 1.0);
  return apparent_velocity_covariance(ray, radial, lateral);
}

}  // namespace kinetrace::segmentation

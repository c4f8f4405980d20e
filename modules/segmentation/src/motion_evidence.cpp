#include "kinetrace/segmentation/motion_evidence.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "patch_similarity.hpp"

namespace kinetrace::segmentation {
namespace {

/// Residual per degree of freedom that a line through the observations may leave.
constexpr double kMaxResidualPerDof = 3.0;
/// A velocity that differs from zero by less says nothing that texture could have faked.
constexpr float kMovingChi2 = 16.F;
/// Patches nearer to each other than this share most of their pixels and always look alike.
constexpr float kMinJumpPx = 6.F;
/// Correlation of two patches that a feature tracker may confuse.
constexpr float kSamePatch = 0.75F;
/// Speed below which a fit says nothing, whatever its formal precision.
constexpr double kVelocityFloorMps = 0.1;

}  // namespace

/// Normal equations of p(t) = x + v t with information matrices L_k:
/// [sum L, sum t L; sum t L, sum t^2 L] [x; v] = [sum L p; sum t L p].
struct MotionEvidence::Sums {
  Eigen::Matrix3d info = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d info_t = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d info_tt = Eigen::Matrix3d::Zero();
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector3d point_t = Eigen::Vector3d::Zero();
  double point_sq = 0.0;
  int count = 0;

  void add(const Observation& o, double t_s, double sign) {
    Eigen::Matrix3d m;
    m << o.information[0], o.information[1], o.information[2],  //
        o.information[1], o.information[3], o.information[4],   //
        o.information[2], o.information[4], o.information[5];
    m *= sign;
    const Eigen::Vector3d p = o.offset_m.cast<double>();
    const Eigen::Vector3d mp = m * p;
    info += m;
    info_t += t_s * m;
    info_tt += t_s * t_s * m;
    point += mp;
    point_t += t_s * mp;
    point_sq += p.dot(mp);
    count += sign > 0.0 ? 1 : -1;
  }
};

struct MotionEvidence::Fit {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double residual_per_dof = 0.0;

  explicit Fit(const Sums& s) {
    const Eigen::Matrix3d info_inverse = s.info.inverse();
    const Eigen::Matrix3d carry = s.info_t * info_inverse;
    information = s.info_tt - carry * s.info_t;
    velocity = information.inverse() * (s.point_t - carry * s.point);
    const Eigen::Vector3d position = info_inverse * (s.point - s.info_t * velocity);
    const double residual = s.point_sq - position.dot(s.point) - velocity.dot(s.point_t);
    residual_per_dof = std::max(0.0, residual) / (3.0 * s.count - 6.0);
  }
};

MotionEvidence::MotionEvidence(const MotionConfig& config, const StereoGeometry& geometry, int max_features,
                               Arena& arena)
    : config_(config),
      geometry_(geometry),
      slots_(arena.take<Slot>(static_cast<std::size_t>(max_features))),
      motions_(arena, static_cast<std::size_t>(max_features)) {}

void MotionEvidence::reset() noexcept {
  // Frame numbers start again, so old observations must not look recent.
  for (Slot& slot : slots_) {
    slot.feature_id = 0;
  }
  frame_ = 0;
  T_world_cam_ = {};
  T_world_prev_ = {};
  ego_speed_mps_ = 0.0;
}

std::span<const FeatureMotion> MotionEvidence::update(std::span<const Feature> features, GrayView left,
                                                      const Se3& T_prev_cam, std::int64_t timestamp_ns) {
  T_world_prev_ = T_world_cam_;
  if (frame_ > 0) {
    T_world_cam_ = (T_world_cam_ * T_prev_cam).orthonormalised();
    interval_s_ = 1e-9 * static_cast<double>(timestamp_ns - time_ns_[ring_index(frame_)]);
    ego_speed_mps_ = interval_s_ > 0.0 ? T_prev_cam.translation.norm() / interval_s_ : 0.0;
  }
  ++frame_;
  time_ns_[ring_index(frame_)] = timestamp_ns;
  motions_.clear();
  for (const Feature& feature : features) {
    FeatureMotion motion;
    if (feature.slot < slots_.size() && feature.has_right() && feature.disparity_px() >= config_.min_disparity_px) {
      Slot& slot = slots_[feature.slot];
      observe(feature, slot);
      motion = fit_motion(feature, slot);
      motion.known = motion.known && !looks_the_same_at_rest(feature, motion, left);
    }
    (void)motions_.push_back(motion);  // beyond max_features the rest has no say
  }
  return motions_.span();
}

void MotionEvidence::observe(const Feature& feature, Slot& slot) const {
  const double disparity_px = feature.disparity_px();
  if (slot.feature_id != feature.id) {
    slot.feature_id = feature.id;
    slot.anchor_m = T_world_cam_ * geometry_.triangulate(feature.left_px.x(), feature.v_px, disparity_px);
    slot.ring.fill({});
    // A feature first shown to us may have been found, and matched, in the previous frame already.
    const double previous_px = feature.previous_left_px.x() - feature.previous_u_right_px;
    if (frame_ > 1 && feature.age_frames > 0 && previous_px >= config_.min_disparity_px) {  // false without a match
      slot.ring[ring_index(frame_ - 1)] = make_observation(feature.previous_left_px.x(), feature.previous_v_px,
                                                           previous_px, T_world_prev_, frame_ - 1, slot.anchor_m);
    }
  }
  slot.ring[ring_index(frame_)] =
      make_observation(feature.left_px.x(), feature.v_px, disparity_px, T_world_cam_, frame_, slot.anchor_m);
}

MotionEvidence::Observation MotionEvidence::make_observation(double u_left_px, double v_px, double disparity_px,
                                                             const Se3& T_world_cam, std::uint32_t frame,
                                                             const Eigen::Vector3d& anchor_m) const {
  const Eigen::Vector3d p_cam = geometry_.triangulate(u_left_px, v_px, disparity_px);
  // Rows of the projection's Jacobian: uL, v, uR.
  const double inv_z = 1.0 / p_cam.z();
  const double x = p_cam.x() * inv_z;
  Eigen::Matrix3d jacobian;
  jacobian << geometry_.fx_px, 0.0, -geometry_.fx_px * x,          //
      0.0, geometry_.fy_px, -geometry_.fy_px * p_cam.y() * inv_z,  //
      geometry_.fx_px, 0.0, -geometry_.fx_px * x + geometry_.fx_px * geometry_.baseline_m * inv_z;
  jacobian *= inv_z / config_.sigma_px;
  const Eigen::Matrix3d in_world = jacobian * T_world_cam.rotation.transpose();
  const Eigen::Matrix3f information = (in_world.transpose() * in_world).cast<float>();
  Observation o;
  o.frame = frame;
  o.offset_m = (T_world_cam * p_cam - anchor_m).cast<float>();
  o.information = {information(0, 0), information(0, 1), information(0, 2),
                   information(1, 1), information(1, 2), information(2, 2)};
  return o;
}

MotionEvidence::Sums MotionEvidence::sum_window(const Slot& slot) const {
  Sums sums;
  const std::int64_t now_ns = time_ns_[ring_index(frame_)];
  for (std::size_t k = 0; k < static_cast<std::size_t>(config_.window_frames); ++k) {
    if (in_window(slot.ring[k])) {
      sums.add(slot.ring[k], 1e-9 * static_cast<double>(time_ns_[k] - now_ns), 1.0);
    }
  }
  return sums;
}

FeatureMotion MotionEvidence::fit_motion(const Feature& feature, const Slot& slot) const {
  FeatureMotion motion;
  motion.depth_m = static_cast<float>(geometry_.depth_m(feature.disparity_px()));
  Sums sums = sum_window(slot);
  if (sums.count < 3) {
    return motion;
  }
  Fit fit(sums);
  const std::int64_t now_ns = time_ns_[ring_index(frame_)];
  double span_s = 0.0;
  std::size_t left_out = kMaxWindowFrames;
  if (fit.residual_per_dof > kMaxResidualPerDof && sums.count > 3) {
    Fit best = fit;
    for (std::size_t k = 0; k < static_cast<std::size_t>(config_.window_frames); ++k) {
      if (!in_window(slot.ring[k])) {
        continue;
      }
      Sums without = sums;
      without.add(slot.ring[k], 1e-9 * static_cast<double>(time_ns_[k] - now_ns), -1.0);
      const Fit candidate(without);
      if (candidate.residual_per_dof < best.residual_per_dof) {
        best = candidate;
        left_out = k;
      }
    }
    fit = best;
  }
  // Without the newest observation the feature is not where it seems to be.
  if (fit.residual_per_dof > kMaxResidualPerDof || left_out == ring_index(frame_)) {
    return motion;
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(config_.window_frames); ++k) {
    if (in_window(slot.ring[k]) && k != left_out) {
      span_s = std::max(span_s, 1e-9 * static_cast<double>(now_ns - time_ns_[k]));
    }
  }
  const Eigen::Matrix3d information = fit.information / std::max(1.0, fit.residual_per_dof);
  motion.known = span_s > 0.0;
  motion.velocity_mps = fit.velocity.cast<float>();
  motion.information = information.cast<float>();
  motion.covariance = information.inverse().cast<float>();
  motion.static_chi2 = static_cast<float>(fit.velocity.dot(information * fit.velocity));
  motion.systematic = systematic_covariance(feature, std::max(span_s, 1e-3));
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

// What a whole region may seem to move without moving: an error of the ego motion shifts its image, a bias of its
// disparity drifts with the viewpoint.
Eigen::Matrix3f MotionEvidence::systematic_covariance(const Feature& feature, double span_s) const {
  const double d = feature.disparity_px();
  const double z = geometry_.depth_m(d);
  const double x = (feature.left_px.x() - geometry_.cx_px) / geometry_.fx_px;
  const double y = (feature.v_px - geometry_.cy_px) / geometry_.fy_px;
  const double lateral = config_.ego_sigma_px * z / geometry_.fx_px / span_s;
  const double radial = config_.bias_disparity_px * z / d / span_s;
  const Eigen::Vector3d ray = T_world_cam_.rotation * Eigen::Vector3d(x, y, 1.0);
  const Eigen::Matrix3d covariance =
      radial * radial * ray * ray.transpose() +
      (lateral * lateral + kVelocityFloorMps * kVelocityFloorMps) * Eigen::Matrix3d::Identity();
  return covariance.cast<float>();
}

}  // namespace kinetrace::segmentation

#include "kinetrace/sfm/body_reconstruction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <Eigen/Cholesky>

#include "columns.hpp"

namespace kinetrace::sfm {
namespace {

// Fewer proven points do not decide on a pose.
constexpr std::size_t kMinConsensus = 5;
// When new points have to decide, all may lie on a moving object. Then the deviation from the body's predicted motion
// is limited to this acceleration since it was last tracked; small, since a wrong pose is worse than none.
constexpr double kUnprovenAcceleration_mps2 = 2.0;
constexpr double kUnprovenSlack_m = 0.05;
constexpr double kGateSigmas = 3.0;

std::size_t as_size(int n) {
  return static_cast<std::size_t>(n);
}

}  // namespace

Result<BodyReconstruction> BodyReconstruction::create(const BodyConfig& config, const StereoGeometry& geometry,
                                                      Arena& arena) {
  if (const Status valid = config.validate("sfm"); !valid) {
    return Unexpected(valid.error());
  }
  if (!(geometry.fx_px > 0.0 && geometry.fy_px > 0.0 && geometry.baseline_m > 0.0)) {
    return fail(ErrorCode::kBadCalibration, "a body reconstruction needs a rectified rig with fx, fy and baseline > 0");
  }
  BodyReconstruction body(config, geometry, arena);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "the arena does not hold a body reconstruction of " +
                                          std::to_string(required_bytes(config)) +
                                          " bytes; size it from the memory plan");
  }
  return body;
}

std::size_t BodyReconstruction::required_bytes(const BodyConfig& config) {
  return measure_bytes([&](Arena& arena) { BodyReconstruction(config, StereoGeometry{}, arena); });
}

BodyReconstruction::BodyReconstruction(const BodyConfig& config, const StereoGeometry& geometry, Arena& arena)
    : config_(config),
      geometry_(geometry),
      pose_estimator_({config.gate_sigma, config.ransac_max_hypotheses}, geometry),
      noise_(config.min_measurement_sigma_px, config.measurement_sigma_px),
      poses_(arena.take<Se3>(as_size(config.window_frames))),
      drifts_(arena.take<Matrix6d>(as_size(config.window_frames))),
      attitudes_(arena.take<CameraAttitude>(as_size(config.window_frames))),
      turns_(arena.take<TurnPrior>(as_size(config.window_frames))),
      map_(arena, as_size(config.max_points), as_size(config.max_features), as_size(config.window_frames)),
      history_(arena, as_size(config.window_frames) + 1),
      verdict_(arena.take<Verdict>(as_size(config.max_features))),
      disagreements_(arena.take<std::uint8_t>(as_size(config.max_features))),
      disagreeing_id_(arena.take<std::uint32_t>(as_size(config.max_features))),
      pose_observations_(arena.take<PoseObservation>(as_size(config.max_points))),
      pose_slots_(arena.take<std::uint16_t>(as_size(config.max_points))),
      pose_inlier_(arena.take<std::uint8_t>(as_size(config.max_points))),
      scratch_(arena.take<float>(as_size(config.max_points))),
      live_(arena, as_size(config.max_points)),
      // A restart retires the whole map, and the following frame may retire again.
      retired_(arena, 2 * as_size(config.max_points)),
      observations_(arena, as_size(config.max_points)),
      rejected_(arena, as_size(config.max_features)) {}

void BodyReconstruction::begin(const Se3& T_body_cam, BodyStatus status) {
  if (active_) {
    for (std::size_t row = 0; row < map_.size(); ++row) {
      retire(row);
    }
    history_.freeze(poses_);
  } else {
    retired_.clear();
    history_.clear();
    last_tracked_ns_.reset();
  }
  map_.clear();
  std::fill(verdict_.begin(), verdict_.end(), Verdict::kUnknown);
  std::fill(disagreeing_id_.begin(), disagreeing_id_.end(), 0U);
  noise_.restart();
  used_columns_ = 0;
  std::fill(drifts_.begin(), drifts_.end(), Matrix6d::Zero());
  newest_redundant_ = false;
  T_body_cam_now_ = T_body_cam;
  status_now_ = status;
  in_window_ = true;
  // A known pose is exact, by definition of the body frame; a predicted one keeps its covariance.
  const Matrix6d covariance = status == BodyStatus::kTracked ? Matrix6d::Zero() : estimate_.covariance;
  estimate_ = BodyEstimate{};
  estimate_.covariance = covariance;
  estimate_.status = status;
  estimate_.T_body_cam = T_body_cam_now_;  // the argument may be the former estimate's
  active_ = true;
}

void BodyReconstruction::end() {
  retired_.clear();
  for (std::size_t row = 0; row < map_.size(); ++row) {
    retire(row);
  }
  history_.freeze(poses_);
  map_.clear();
  live_.clear();
  observations_.clear();
  rejected_.clear();
  used_columns_ = 0;
  active_ = false;
  estimate_.status = BodyStatus::kLost;
  estimate_.points = {};
  estimate_.frame_observations = {};
  estimate_.retired = retired_.span();
}

void BodyReconstruction::reset() {
  end();
  retired_.clear();
  history_.clear();
  estimate_ = BodyEstimate{};
}

Se3 BodyReconstruction::predict(std::int64_t timestamp_ns) const {
  if (history_.size() == 0) {
    return T_body_cam_now_;
  }
  const FinalisedPose last = history(0);
  if (history_.size() < 2) {
    return last.T_body_cam;
  }
  const FinalisedPose before = history(1);
  const auto step_ns = static_cast<double>(last.timestamp_ns - before.timestamp_ns);
  const double s = step_ns > 0.0 ? static_cast<double>(timestamp_ns - last.timestamp_ns) / step_ns : 0.0;
  const Se3 motion = before.T_body_cam.inverse() * last.T_body_cam;
  return (last.T_body_cam * interpolate(Se3{}, motion, std::clamp(s, 0.0, 5.0))).orthonormalised();
}

void BodyReconstruction::predict_features(std::span<const Feature> previous, std::uint8_t label,
                                          std::int64_t timestamp_ns, std::span<FeaturePrediction> by_slot) const {
  if (!active_ || history_.size() < 2) {
    return;
  }
  const Se3 T_cam_body = predict(timestamp_ns).inverse();
  const Se3 T_body_previous = history(0).T_body_cam;
  for (const Feature& feature : previous) {
    if (feature.body != label) {
      continue;
    }
    const std::size_t row = map_.find(feature);
    Eigen::Vector3d p_body;
    if (row != PointMap::kNone && map_.state(row).positioned) {
      p_body = map_.point(row).position_m;
    } else if (feature.has_right() && feature.disparity_px() >= static_cast<float>(config_.min_disparity_px)) {
      p_body = T_body_previous *
               geometry_.triangulate(double{feature.left_px.x()}, double{feature.v_px}, double{feature.disparity_px()});
    } else {
      continue;
    }
    const Eigen::Vector3d p_cam = T_cam_body * p_body;
    if (p_cam.z() < kMinProjectionDepth_m) {
      continue;
    }
    const Eigen::Vector3d uvr = geometry_.project(p_cam);
    // The last offset (v against the pair's mean row, reprojection error) is assumed constant.
    by_slot[feature.slot] = {
        .left_px = uvr.head<2>().cast<float>() + Eigen::Vector2f(0.F, feature.left_px.y() - feature.v_px),
        .disparity_px = static_cast<float>(uvr.x() - uvr.z()),
        .known = true};
  }
}

PosePrior BodyReconstruction::prior_from(const Expectation& expected) {
  PosePrior prior{expected.T_body_cam.inverse()};
  // The inverse pose has the same perturbation, transformed by the adjoint and with opposite sign.
  const Matrix6d ad = adjoint(prior.T_cam_body);
  prior.information = (ad * expected.covariance * ad.transpose()).ldlt().solve(Matrix6d::Identity());
  return prior;
}

BodyReconstruction::ObservedPoints BodyReconstruction::observe_points(const FeatureFrame& frame, std::uint8_t label) {
  ObservedPoints observed;
  const auto add = [&](int least, int most) {
    for (const Feature& feature : frame.features) {
      const std::size_t row = feature.body == label ? map_.find(feature) : PointMap::kNone;
      if (row == PointMap::kNone || !map_.state(row).positioned) {
        continue;
      }
      const std::uint16_t seen = map_.state(row).observations;
      if (seen < least || seen > most) {
        continue;
      }
      pose_slots_[observed.count] = feature.slot;
      pose_observations_[observed.count++] = {.p_body = map_.point(row).position_m,
                                              .u_left_px = feature.left_px.x(),
                                              .v_px = feature.v_px,
                                              .u_right_px = feature.u_right_px,
                                              .variance_ratio = 1.F + 1.F / static_cast<float>(seen)};
    }
  };
  constexpr int kAny = std::numeric_limits<int>::max();
  const int min_observations = config_.min_observations_for_consensus;
  add(min_observations, kAny);
  observed.consensus_size = observed.count;
  observed.is_proven = min_observations == 0 || observed.consensus_size >= kMinConsensus;
  for (const auto& [least, most] : {std::pair{min_observations - 1, min_observations - 1}, {0, min_observations - 2}}) {
    add(least, most);
    if (observed.consensus_size < kMinConsensus) {
      observed.consensus_size = observed.count;
    }
  }
  return observed;
}

bool BodyReconstruction::is_plausible(const PoseEstimate& pose) const {
  if (!last_tracked_ns_ || history_.size() < 2) {
    return true;  // Motion unknown.
  }
  const double step_s = static_cast<double>(timestamp_ns_ - history(0).timestamp_ns) * 1e-9;
  const double untracked_s = static_cast<double>(timestamp_ns_ - *last_tracked_ns_) * 1e-9;
  const double unexpected_m = (pose.T_cam_body.inverse().translation - predict(timestamp_ns_).translation).norm();
  const double sigma_m = std::sqrt(pose.covariance.bottomRightCorner<3, 3>().trace());
  return unexpected_m <= kUnprovenSlack_m + kGateSigmas * sigma_m + kUnprovenAcceleration_mps2 * untracked_s * step_s;
}

PoseEstimate BodyReconstruction::find_pose(const ObservedPoints& observed, const PosePrior& prior, double sigma_px) {
  PoseEstimate pose = pose_estimator_.estimate(pose_observations_.first(observed.count), prior, sigma_px,
                                               pose_inlier_.first(observed.count), observed.consensus_size);
  const auto enough = static_cast<int>(config_.min_inlier_ratio * static_cast<double>(observed.consensus_size));
  pose.valid = pose.valid && pose.inliers >= config_.min_inliers && pose.agreeing_consensus >= enough &&
               (observed.is_proven || is_plausible(pose));
  return pose;
}

void BodyReconstruction::learn_noise(std::span<const PoseObservation> observations, const Se3& T_cam_body) {
  std::size_t count = 0;
  for (const PoseObservation& o : observations) {
    if (!std::isnan(o.u_right_px)) {
      scratch_[count++] = static_cast<float>(reprojection_chi2(geometry_, T_cam_body, o, 1.0));
    }
  }
  noise_.learn(scratch_.first(count));
}

void BodyReconstruction::inflate_covariance() {
  if (history_.size() == 0) {
    return;
  }
  const Se3 motion = history(0).T_body_cam.inverse() * T_body_cam_now_;
  Vector6d variance;
  variance.head<3>().setConstant(so3_log(motion.rotation).squaredNorm());
  variance.tail<3>().setConstant(motion.translation.squaredNorm());
  const Matrix6d ad = adjoint(T_body_cam_now_);
  estimate_.covariance += ad * variance.asDiagonal() * ad.transpose();
}

const BodyEstimate& BodyReconstruction::locate(const FeatureFrame& frame, std::uint8_t label,
                                               const Expectation* expected) {
  retired_.clear();
  frame_index_ = frame.frame_index;
  timestamp_ns_ = frame.timestamp_ns;
  std::fill(verdict_.begin(), verdict_.end(), Verdict::kUnknown);
  T_body_cam_now_ = expected != nullptr ? expected->T_body_cam : predict(frame.timestamp_ns);
  const PosePrior prior = expected != nullptr ? prior_from(*expected) : PosePrior{T_body_cam_now_.inverse()};

  const ObservedPoints observed = observe_points(frame, label);
  const double weighted_for_px = noise_.sigma_px();
  PoseEstimate pose = find_pose(observed, prior, noise_.sigma_px());
  if (!pose.valid && noise_.sigma_px() < noise_.most_px()) {
    // The images may have become worse at once, by blur or darkness, which invalidates the noise scale.
    noise_.restart();
    pose = find_pose(observed, prior, noise_.sigma_px());
  }
  const bool found = pose.valid;
  estimate_.observations = static_cast<int>(observed.count);
  estimate_.inliers = pose.inliers;
  if (found) {
    last_tracked_ns_ = timestamp_ns_;
    T_body_cam_now_ = pose.T_cam_body.inverse();
    const Matrix6d ad = adjoint(T_body_cam_now_);
    estimate_.covariance = ad * pose.covariance * ad.transpose();
    learn_noise(pose_observations_.first(observed.consensus_size), pose.T_cam_body);
    for (std::size_t i = 0; i < observed.count; ++i) {
      verdict_[pose_slots_[i]] = pose_inlier_[i] != 0 ? Verdict::kInlier : Verdict::kOutlier;
    }
  }
  if (!found) {
    inflate_covariance();
  }
  map_.scale_weights(static_cast<float>(weighted_for_px / noise_.sigma_px()));
  in_window_ = found;
  status_now_ = found ? BodyStatus::kTracked : BodyStatus::kPropagated;
  estimate_.status = status_now_;
  estimate_.T_body_cam = T_body_cam_now_;
  return estimate_;
}

void BodyReconstruction::remeasure(const RigChange& change) noexcept {
  map_.remeasure(change);
}

void BodyReconstruction::refuse_pose() {
  T_body_cam_now_ = predict(timestamp_ns_);
  inflate_covariance();
  std::fill(verdict_.begin(), verdict_.end(), Verdict::kUnknown);
  in_window_ = false;
  status_now_ = BodyStatus::kPropagated;
  estimate_.status = status_now_;
  estimate_.T_body_cam = T_body_cam_now_;
  estimate_.inliers = 0;
}

void BodyReconstruction::extend(const FeatureFrame& frame, std::uint8_t label, const Eigen::Matrix3d* R_world_cam) {
  frame_index_ = frame.frame_index;
  timestamp_ns_ = frame.timestamp_ns;
  rejected_.clear();
  const FinalisedPose now{frame_index_,    timestamp_ns_,        status_now_,
                          T_body_cam_now_, estimate_.covariance, estimate_.inliers};
  if (!in_window_) {
    history_.push(now, PoseHistory::kFrozen);
    return;
  }
  advance_window();
  poses_[newest_column()] = T_body_cam_now_;
  attitudes_[newest_column()] = {R_world_cam != nullptr ? *R_world_cam : Eigen::Matrix3d::Identity(), timestamp_ns_,
                                 R_world_cam != nullptr};
  if (used_columns_ == 1) {
    std::fill(poses_.begin(), poses_.end(), T_body_cam_now_);
  }
  history_.push(now, newest_column());
  add_observations(frame, label);
  position_new_points();
}

void BodyReconstruction::publish() {
  live_.clear();
  observations_.clear();
  for (std::size_t row = 0; row < map_.size(); ++row) {
    const PointState& state = map_.state(row);
    if (!state.positioned) {
      continue;
    }
    static_cast<void>(live_.push_back(
        {state.id, map_.point(row).position_m.cast<float>(), state.error_px, state.observations, state.intensity}));
    if ((state.seen & bit(newest_column())) != 0 && in_window_) {
      const BundleObservation& o = map_.observations(row)[newest_column()];
      static_cast<void>(observations_.push_back({state.id, o.u_left_px, o.v_px, o.u_right_px}));
    }
  }
  estimate_.points = live_.span();
  estimate_.frame_observations = observations_.span();
  estimate_.retired = retired_.span();
}

const BodyEstimate& BodyReconstruction::conclude(const BundleSummary& refinement) {
  if (in_window_) {
    for (Se3& pose : poses_) {
      pose = pose.orthonormalised();
    }
    reposition_newcomers();
    cull_points();
    T_body_cam_now_ = poses_[newest_column()];
    newest_redundant_ = newest_is_redundant();
    if (refinement.newest_covariance.allFinite() && refinement.newest_covariance.trace() > 0.0) {
      estimate_.covariance = refinement.newest_covariance;
      estimate_.drift_covariance = drifts_[anchor_column_];
    }
    drifts_[newest_column()] = estimate_.drift_covariance + estimate_.covariance;
  }
  estimate_.status = status_now_;
  estimate_.T_body_cam = T_body_cam_now_;
  estimate_.is_keyframe = in_window_ && !newest_redundant_;
  publish();
  if (in_window_) {
    estimate_.inliers = static_cast<int>(observations_.size());
  }
  history_.update_newest(status_now_, estimate_.covariance, estimate_.inliers);
  return estimate_;
}

}  // namespace kinetrace::sfm

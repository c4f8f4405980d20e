#include "kinetrace/geo/alignment.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <Eigen/Cholesky>

#include "alignment_search.hpp"
#include "alignment_verdict.hpp"
#include "kinetrace/core/quantiles.hpp"
#include "normal_equations.hpp"

namespace kinetrace::geo {
namespace {

Status validate(std::span<const PathPose> path, const AlignmentConfig& config) {
  const auto is_in_order = [](const PathPose& a, const PathPose& b) { return a.time_ns < b.time_ns; };
  if (path.size() < 2 || std::adjacent_find(path.begin(), path.end(), std::not_fn(is_in_order)) != path.end()) {
    return fail(ErrorCode::kInvalidArgument, "a path needs two poses or more, in order of time");
  }
  // Written so that NaN fails.
  if (!std::all_of(path.begin(), path.end(), [](const PathPose& pose) {
        return pose.T_world_cam.rotation.allFinite() && pose.T_world_cam.translation.norm() <= kMaxPosition_m;
      })) {
    return fail(ErrorCode::kInvalidArgument, "a pose lies farther than 10000 km from where the path began");
  }
  constexpr double kMaxLever_m = 100.0;
  constexpr double kMaxSearch_s = 3600.0;
  const bool is_valid = config.lever_arm_m.allFinite() && config.lever_arm_m.norm() <= kMaxLever_m &&
                        std::abs(config.time_offset_s) <= 4e9 && config.max_time_offset_s >= 0.0 &&
                        config.max_time_offset_s <= kMaxSearch_s && config.path_drift >= 0.0 &&
                        config.path_drift <= 1.0 && config.max_pose_gap_s > 0.0 && config.max_rotation_sigma_rad > 0.0;
  return is_valid ? Status{}
                  : fail(ErrorCode::kInvalidArgument,
                         "alignment settings out of range: lever arm within 100 m, search of the time offset within an "
                         "hour, drift of the path 0 to 1");
}

Eigen::Vector3d center_of(std::span<const Match> matches, const Se3& T_map_world) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Match& match : matches) {
    sum += T_map_world * match.point.world_m;
  }
  return sum / static_cast<double>(matches.size());
}

void apply(const UnknownVector& step, const AlignmentConfig& config, const Eigen::Vector3d& center_m,
           AlignmentStart& state) {
  const Eigen::Matrix3d turn = so3_exp(step.head<3>());
  Se3& T = state.T_map_world;
  T = Se3{turn * T.rotation, turn * (T.translation - center_m) + center_m + step.segment<3>(3)}.orthonormalised();
  state.time_offset_s =
      std::clamp(state.time_offset_s + step[kOffsetUnknown], config.time_offset_s - config.max_time_offset_s,
                 config.time_offset_s + config.max_time_offset_s);
}

/// Matches at the current state, with their weights.
struct Linearisation {
  std::vector<Match> matches;
  std::vector<Residual> residuals;
  NoiseScale noise;
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();
};

Linearisation linearise_at(const AntennaPath& path, std::span<const Fix> fixes, const AlignmentStart& state) {
  Linearisation linear;
  linear.matches = match(path, fixes, state.time_offset_s);
  if (!linear.matches.empty()) {
    linear.center_m = center_of(linear.matches, state.T_map_world);
    linear.residuals = linearise(linear.matches, state.T_map_world, linear.center_m);
    linear.noise = weigh(linear.matches, linear.residuals);
  }
  return linear;
}

/// Gauss-Newton; inliers are selected again in each step.
Linearisation refine(const AntennaPath& path, std::span<const Fix> fixes, const AlignmentConfig& config,
                     AlignmentStart& state) {
  const std::vector<int> unknowns = free_unknowns(config, false);
  constexpr int kMaxSteps = 50;
  Linearisation linear = linearise_at(path, fixes, state);
  for (int i = 0; i < kMaxSteps && linear.matches.size() >= kMinFixes; ++i) {
    const Eigen::MatrixXd H = information(linear.residuals, config)(unknowns, unknowns);
    const Eigen::VectorXd g = gradient(linear.residuals)(unknowns);
    UnknownVector step = UnknownVector::Zero();
    const Eigen::VectorXd solution = H.ldlt().solve(g);
    step(unknowns) = solution;
    // Squared, in standard deviations.
    const bool is_converged = g.dot(solution) < 1e-8;
    apply(step, config, linear.center_m, state);
    linear = linearise_at(path, fixes, state);
    if (is_converged) {
      break;
    }
  }
  return linear;
}

void report_noise(const Linearisation& linear, Alignment& alignment) {
  std::vector<double> horizontal_m;
  std::vector<double> vertical_m;
  for (const Match& match : linear.matches) {
    horizontal_m.push_back(match.sigma_m.head<2>().norm() / std::sqrt(2.0));
    vertical_m.push_back(match.sigma_m.z());
  }
  alignment.sigma_factor = {linear.noise.horizontal, linear.noise.horizontal, linear.noise.vertical};
  alignment.horizontal_noise_m = linear.noise.horizontal * median(horizontal_m);
  alignment.vertical_noise_m = linear.noise.vertical * median(vertical_m);
}

/// The result without its verdict.
Alignment describe(const Linearisation& linear, const AntennaPath& path, std::size_t fixes,
                   const AlignmentConfig& config, const AlignmentStart& state) {
  Alignment alignment;
  alignment.T_map_world = state.T_map_world;
  alignment.center_m = linear.center_m;
  alignment.time_offset_s = state.time_offset_s;
  alignment.path_m = path.length_m();
  alignment.fixes = static_cast<std::int64_t>(linear.matches.size());
  alignment.unmatched = static_cast<std::int64_t>(fixes - linear.matches.size());
  alignment.use.resize(fixes, FixUse::kUnmatched);
  for (const Residual& residual : linear.residuals) {
    alignment.use[residual.fix] = residual.is_inlier() ? FixUse::kInlier : FixUse::kOutlier;
    alignment.inliers += residual.is_inlier() ? 1 : 0;
  }
  if (linear.matches.size() < kMinFixes) {
    return alignment;
  }
  report_noise(linear, alignment);
  alignment.correlation = correlation_time(linear.residuals);
  const UnknownMatrix H = information(linear.residuals, config);
  const double drift_m = config.path_drift * path.length_m();
  const UnknownMatrix rigid =
      covariance(linear.residuals, H, free_unknowns(config, false), alignment.correlation, drift_m, path.length_m());
  alignment.covariance = rigid.topLeftCorner<6, 6>();
  alignment.time_offset_sigma_s = std::sqrt(rigid(kOffsetUnknown, kOffsetUnknown));
  const std::vector<int> with_scale = free_unknowns(config, true);
  const Eigen::MatrixXd small = H(with_scale, with_scale);
  const Eigen::VectorXd g = gradient(linear.residuals)(with_scale);
  const Eigen::VectorXd step = small.ldlt().solve(g);
  alignment.scale = 1.0 + step[step.size() - 1];
  alignment.scale_sigma = std::sqrt(covariance(linear.residuals, H, with_scale, alignment.correlation, drift_m,
                                               path.length_m())(kScaleUnknown, kScaleUnknown));
  return alignment;
}

}  // namespace

Eigen::Matrix3d position_covariance(const Alignment& alignment, const Eigen::Vector3d& map_m) {
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << -skew(map_m - alignment.center_m), Eigen::Matrix3d::Identity();
  return jacobian * alignment.covariance * jacobian.transpose();
}

Result<Alignment> align(std::span<const PathPose> path, std::span<const Fix> fixes, const AlignmentConfig& config) {
  if (const Status valid = validate(path, config); !valid) {
    return Unexpected(valid.error());
  }
  const AntennaPath antenna(path, config);
  std::optional<AlignmentStart> state = fixes.empty() ? std::nullopt : search_start(antenna, fixes, config);
  if (!state) {
    Alignment alignment;
    alignment.path_m = antenna.length_m();
    alignment.unmatched = static_cast<std::int64_t>(fixes.size());
    alignment.use.resize(fixes.size(), FixUse::kUnmatched);
    alignment.reason = too_few_fixes(antenna, fixes, config);
    return alignment;
  }
  const Linearisation linear = refine(antenna, fixes, config, *state);
  Alignment alignment = describe(linear, antenna, fixes.size(), config, *state);
  alignment.reason = linear.matches.size() < kMinFixes ? too_few_fixes(antenna, fixes, config)
                                                       : what_is_missing(alignment, linear.residuals, config);
  alignment.verdict = alignment.reason.empty() ? Verdict::kAligned : Verdict::kRefused;
  return alignment;
}

}  // namespace kinetrace::geo

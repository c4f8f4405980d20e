#include "kinetrace/refinement/ceres_bundle_adjuster.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <ceres/ceres.h>

#include "kinetrace/core/allocation_counter.hpp"
#include "marginal_covariance.hpp"
#include "reprojection_jacobian.hpp"
#include "turn_residual.hpp"
#include "window_check.hpp"

namespace kinetrace::refinement {
namespace {

constexpr int kPoseAmbient = 12;  // Rotation matrix by columns, then translation.
constexpr int kPoseTangent = 6;
using PoseBlock = std::array<double, kPoseAmbient>;
using PoseDerivative = Eigen::Matrix<double, 3, kPoseAmbient, Eigen::RowMajor>;
using PointDerivative = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Se3 to_pose(const double* block) {
  return {Eigen::Map<const Eigen::Matrix3d>(block), Eigen::Map<const Eigen::Vector3d>(block + 9)};
}

void from_pose(const Se3& pose, double* block) {
  Eigen::Map<Eigen::Matrix3d>(block, 3, 3) = pose.rotation;
  Eigen::Map<Eigen::Vector3d>(block + 9, 3) = pose.translation;
}

/// T_cam_body under the project's left perturbation. Cost functions write derivatives with respect to the perturbation
/// into the first six columns, so that the plus-Jacobian is simply [ I ; 0 ].
class LeftPerturbation final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPoseAmbient; }
  int TangentSize() const override { return kPoseTangent; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    from_pose(left_update(to_pose(x), Vector6d(delta)).orthonormalised(), x_plus_delta);
    return true;
  }
  bool PlusJacobian(const double* /*x*/, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, kPoseAmbient, kPoseTangent, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    Eigen::Map<Vector6d>(y_minus_x, kPoseTangent) = left_difference(to_pose(x), to_pose(y));
    return true;
  }
  bool MinusJacobian(const double* /*x*/, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, kPoseTangent, kPoseAmbient, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
};

class ReprojectionCost final : public ceres::SizedCostFunction<3, kPoseAmbient, 3> {
 public:
  ReprojectionCost(const StereoGeometry& geometry, const BundleObservation& seen) : geometry_(&geometry), seen_(seen) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Se3 T_cam_body = to_pose(parameters[0]);
    const Eigen::Vector3d p_cam = T_cam_body * Eigen::Map<const Eigen::Vector3d>(parameters[1]);
    const ReprojectionJacobian r = reprojection_jacobian(*geometry_, seen_, p_cam);
    Eigen::Map<Eigen::Vector3d>(residuals, 3) = r.residual;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<PoseDerivative> pose(jacobians[0]);
      pose.setZero();
      pose.leftCols<kPoseTangent>() = r.d_point * pose_jacobian(p_cam);
    }
    if (jacobians != nullptr && jacobians[1] != nullptr) {
      Eigen::Map<PointDerivative>(jacobians[1], 3, 3) = r.d_point * T_cam_body.rotation;
    }
    return true;
  }

 private:
  const StereoGeometry* geometry_;
  BundleObservation seen_;
};

class TurnCost final : public ceres::SizedCostFunction<3, kPoseAmbient, kPoseAmbient> {
 public:
  explicit TurnCost(const TurnPrior& prior) : prior_(prior) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    Eigen::Map<Eigen::Vector3d>(residuals, 3) =
        turn_residual(prior_, to_pose(parameters[0]).rotation, to_pose(parameters[1]).rotation);
    const std::array<Eigen::Matrix3d, 2> derivative{prior_.R_before_now.transpose(), -Eigen::Matrix3d::Identity()};
    for (std::size_t i = 0; jacobians != nullptr && i < derivative.size(); ++i) {
      if (jacobians[i] != nullptr) {
        Eigen::Map<PoseDerivative> pose(jacobians[i]);
        pose.setZero();
        pose.leftCols<3>() = prior_.inverse_sigma_rad * derivative[i];
      }
    }
    return true;
  }

 private:
  TurnPrior prior_;
};

ceres::Solver::Options solver_options(const CeresBundleConfig& config, std::size_t frames) {
  // Above this many cameras the reduced system is mostly zero.
  constexpr std::size_t kDenseFrames = 50;
  ceres::Solver::Options options;
  options.linear_solver_type = frames <= kDenseFrames ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
  options.max_num_iterations = config.max_iterations;
  options.num_threads = config.threads;
  options.function_tolerance = config.relative_cost_tolerance;
  // The cost decides alone when to stop, as in the online solver.
  options.gradient_tolerance = 0.0;
  options.parameter_tolerance = 0.0;
  options.logging_type = ceres::SILENT;
  return options;
}

Status check_batch(const BatchProblem& batch) {
  if (batch.fixed_frames.empty() && !batch.T_body_cam.empty()) {
    return fail(ErrorCode::kInvalidArgument, "batch problem has no fixed frame: name at least one in fixed_frames");
  }
  for (const std::uint32_t frame : batch.fixed_frames) {
    if (frame >= batch.T_body_cam.size()) {
      return fail(ErrorCode::kInvalidArgument, "fixed frame " + std::to_string(frame) + " is not in the batch problem");
    }
  }
  for (std::size_t k = 0; k < batch.T_body_cam.size(); ++k) {
    if (!batch.T_body_cam[k].is_finite()) {
      return fail(ErrorCode::kInvalidArgument, "pose of batch frame " + std::to_string(k) + " is not finite");
    }
  }
  for (std::size_t i = 0; i < batch.observations.size(); ++i) {
    const BatchObservation& seen = batch.observations[i];
    if (seen.frame >= batch.T_body_cam.size() || seen.point >= batch.points_m.size() || !is_valid(seen.observation) ||
        !batch.points_m[seen.point].allFinite()) {
      return fail(ErrorCode::kInvalidArgument, "batch observation " + std::to_string(i) +
                                                   " is not finite, or names a frame or point that does not exist");
    }
  }
  if (Status turns = check_turns(batch.turns, batch.T_body_cam.size()); !turns) {
    return turns;
  }
  return check_geometry(batch.geometry);
}

std::vector<bool> fixed_frames(const BatchProblem& batch) {
  std::vector<bool> fixed(batch.T_body_cam.size(), false);
  for (const std::uint32_t frame : batch.fixed_frames) {
    fixed[frame] = true;
  }
  return fixed;
}

/// Adds what each observation and each turn says; points are eliminated before poses. The losses outlive the problem.
void add_residuals(BatchProblem& batch, std::vector<PoseBlock>& poses, ceres::LossFunction& loss,
                   ceres::LossFunction& turn_loss, ceres::Problem& problem, ceres::ParameterBlockOrdering& ordering) {
  for (const BatchObservation& seen : batch.observations) {
    double* point = batch.points_m[seen.point].data();
    problem.AddResidualBlock(new ReprojectionCost(batch.geometry, seen.observation), &loss, poses[seen.frame].data(),
                             point);
    ordering.AddElementToGroup(point, 0);
    ordering.AddElementToGroup(poses[seen.frame].data(), 1);
  }
  for (std::size_t k = 1; k < batch.turns.size(); ++k) {
    problem.AddResidualBlock(new TurnCost(batch.turns[k]), &turn_loss, poses[k - 1].data(), poses[k].data());
    ordering.AddElementToGroup(poses[k - 1].data(), 1);
    ordering.AddElementToGroup(poses[k].data(), 1);
  }
}

Result<BundleSummary> solve(const CeresBundleConfig& config, BatchProblem& batch) {
  std::vector<PoseBlock> poses(batch.T_body_cam.size());
  for (std::size_t k = 0; k < poses.size(); ++k) {
    from_pose(batch.T_body_cam[k].inverse(), poses[k].data());
  }
  ceres::CauchyLoss loss(config.robust_threshold_sigmas);
  ceres::CauchyLoss turn_loss(kTurnThreshold);
  LeftPerturbation manifold;
  ceres::Problem::Options problem_options;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.disable_all_safety_checks = true;
  ceres::Problem problem(problem_options);
  ceres::Solver::Options options = solver_options(config, poses.size());
  options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  add_residuals(batch, poses, loss, turn_loss, problem, *options.linear_solver_ordering);
  const std::vector<bool> fixed = fixed_frames(batch);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    if (problem.HasParameterBlock(poses[k].data())) {
      problem.SetManifold(poses[k].data(), &manifold);
      if (fixed[k]) {
        problem.SetParameterBlockConstant(poses[k].data());
      }
    }
  }
  ceres::Solver::Summary report;
  ceres::Solve(options, &problem, &report);
  if (!report.IsSolutionUsable()) {
    return fail(ErrorCode::kInternal, "batch refinement failed: " + report.message);
  }
  for (std::size_t k = 0; k < poses.size(); ++k) {
    if (!fixed[k] && problem.HasParameterBlock(poses[k].data())) {
      batch.T_body_cam[k] = to_pose(poses[k].data()).inverse();
    }
  }
  BundleSummary summary;
  summary.iterations = static_cast<int>(report.iterations.size()) - 1;
  summary.initial_cost = report.initial_cost;
  summary.final_cost = report.final_cost;
  summary.converged = report.termination_type == ceres::CONVERGENCE;
  return summary;
}

bool has_free_frame(const BatchProblem& batch) {
  const std::vector<bool> fixed = fixed_frames(batch);
  return std::find(fixed.begin(), fixed.end(), false) != fixed.end();
}

}  // namespace

Status CeresBundleConfig::validate() const {
  if (max_iterations < 1) {
    return fail(ErrorCode::kInvalidConfig,
                "refinement.batch.max_iterations must be at least 1, got " + std::to_string(max_iterations));
  }
  if (threads < 1) {
    return fail(ErrorCode::kInvalidConfig,
                "refinement.batch.threads must be at least 1, got " + std::to_string(threads));
  }
  if (!(robust_threshold_sigmas >= 0.1 && robust_threshold_sigmas <= 100.0)) {
    return fail(ErrorCode::kInvalidConfig, "refinement.batch.robust_threshold_sigmas must be in [0.1, 100], got " +
                                               std::to_string(robust_threshold_sigmas));
  }
  if (!(relative_cost_tolerance >= 0.0 && relative_cost_tolerance < 1.0)) {
    return fail(ErrorCode::kInvalidConfig, "refinement.batch.relative_cost_tolerance must be in [0, 1), got " +
                                               std::to_string(relative_cost_tolerance));
  }
  return {};
}

Result<CeresBundleAdjuster> CeresBundleAdjuster::create(const CeresBundleConfig& config) {
  if (Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  return CeresBundleAdjuster(config);
}

Result<BundleSummary> CeresBundleAdjuster::refine_batch(BatchProblem& problem) {
  const ForeignCall foreign;
  if (Status valid = check_batch(problem); !valid) {
    return Unexpected(valid.error());
  }
  if (problem.observations.empty() || !has_free_frame(problem)) {
    BundleSummary nothing_to_do;
    nothing_to_do.converged = true;
    return nothing_to_do;
  }
  return solve(config_, problem);
}

Result<BundleSummary> CeresBundleAdjuster::refine(BundleWindow& window) {
  const ForeignCall foreign;
  if (Status valid = check_window(window); !valid) {
    return Unexpected(valid.error());
  }
  const std::size_t frames = window.T_body_cam.size();
  std::vector<std::uint32_t> fixed;
  for (std::uint32_t rest = window.fixed_frames & frame_mask(frames); rest != 0; rest &= rest - 1) {
    fixed.push_back(static_cast<std::uint32_t>(std::countr_zero(rest)));
  }
  std::vector<Eigen::Vector3d> points(window.points.size());
  std::vector<BatchObservation> observations;
  for (std::size_t p = 0; p < points.size(); ++p) {
    points[p] = window.points[p].position_m;
    for (std::uint32_t rest = window.points[p].frames & frame_mask(frames); rest != 0; rest &= rest - 1) {
      const auto frame = static_cast<std::uint32_t>(std::countr_zero(rest));
      observations.push_back({static_cast<std::uint32_t>(p), frame, window.observation(p, frame)});
    }
  }
  BatchProblem problem{window.geometry, window.T_body_cam, fixed, points, observations, window.turns};
  if (observations.empty() || fixed.size() == frames) {
    BundleSummary nothing_to_do;
    nothing_to_do.converged = true;
    return nothing_to_do;
  }
  Result<BundleSummary> summary = refine_batch(problem);
  if (!summary) {
    return summary;
  }
  for (std::size_t p = 0; p < points.size(); ++p) {
    window.points[p].position_m = points[p];
  }
  summary->newest_covariance = newest_marginal_covariance(window, config_.robust_threshold_sigmas);
  return summary;
}

}  // namespace kinetrace::refinement

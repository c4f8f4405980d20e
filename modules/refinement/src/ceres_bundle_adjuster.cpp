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
#include "motion_costs.hpp"
#include "pose_block.hpp"
#include "pose_marginals.hpp"
#include "reprojection_jacobian.hpp"
#include "turn_residual.hpp"
#include "window_check.hpp"

namespace kinetrace::refinement {
namespace {

using PointDerivative = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

class ReprojectionCost final : public ceres::SizedCostFunction<3, kPoseAmbient, 3> {
 public:
  ReprojectionCost(const StereoGeometry& geometry, const BundleObservation& seen) : geometry_(&geometry), seen_(seen) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Se3 T_cam_body = to_pose(parameters[0]);
    const Eigen::Vector3d p_cam = T_cam_body * Eigen::Map<const Eigen::Vector3d>(parameters[1]);
    const ReprojectionJacobian r = reprojection_jacobian(*geometry_, seen_, p_cam);
    Eigen::Map<Eigen::Vector3d>(residuals, 3) = r.residual;
    if (jacobians != nullptr) {
      put_derivative<3>(r.d_point * pose_jacobian(p_cam), jacobians[0]);
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
        Eigen::Map<PoseDerivative<3>> pose(jacobians[i]);
        pose.setZero();
        pose.leftCols<3>() = prior_.inverse_sigma_rad * derivative[i];
      }
    }
    return true;
  }

 private:
  TurnPrior prior_;
};

ceres::Solver::Options solver_options(const CeresBundleConfig& config, const BatchProblem& batch) {
  // Above this many cameras the reduced system is mostly zero.
  constexpr std::size_t kDenseFrames = 50;
  ceres::Solver::Options options;
  const bool is_dense = batch.T_body_cam.size() <= kDenseFrames;
  // Schur solvers need points to eliminate.
  options.linear_solver_type = batch.observations.empty() ? ceres::SPARSE_NORMAL_CHOLESKY
                               : is_dense                 ? ceres::DENSE_SCHUR
                                                          : ceres::SPARSE_SCHUR;
  options.max_num_iterations = config.max_iterations;
  options.num_threads = config.threads;
  options.function_tolerance = config.relative_cost_tolerance;
  // Only the cost decides on convergence, as in the online solver.
  options.gradient_tolerance = 0.0;
  options.parameter_tolerance = 0.0;
  options.logging_type = ceres::SILENT;
  return options;
}

Status check_motion(const BatchProblem& batch) {
  const std::size_t frames = batch.T_body_cam.size();
  const bool fits =
      !batch.motion || (batch.motion->T_world_cam.size() == frames && batch.motion->timestamps_ns.size() == frames &&
                        batch.motion->at_rest.size() == frames);
  const bool poses_fit =
      std::all_of(batch.measured_poses.begin(), batch.measured_poses.end(), [&](const BatchPose& pose) {
        return batch.motion && pose.frame < frames && pose.T_world_body.is_finite() && pose.inverse_sigma.allFinite();
      });
  const auto steps_fit = [&](std::span<const BatchStep> steps) {
    return std::all_of(steps.begin(), steps.end(), [&](const BatchStep& step) {
      return step.from < frames && step.to < frames && step.from != step.to && step.T_from_to.is_finite() &&
             step.root_information.allFinite();
    });
  };
  const bool fixes_fit = std::all_of(batch.fixes.begin(), batch.fixes.end(), [&](const BatchFix& fix) {
    const std::array<std::uint32_t, 3> entries{fix.map, fix.before, fix.after};
    return *std::max_element(entries.begin(), entries.end()) < frames && fix.map != fix.before &&
           fix.map != fix.after && fix.before != fix.after && fix.part >= 0.0 && fix.part <= 1.0 &&
           fix.antenna_m.allFinite() && fix.position_m.allFinite() && fix.inverse_sigma.allFinite();
  });
  if (!fits || !poses_fit || !fixes_fit || !steps_fit(batch.measured_steps) || !steps_fit(batch.loops)) {
    return fail(ErrorCode::kInvalidArgument,
                "motion, poses, steps or fixes of the batch problem are not those of its frames");
  }
  for (std::size_t k = 1; batch.motion && k < frames; ++k) {
    if (batch.motion->timestamps_ns[k] <= batch.motion->timestamps_ns[k - 1]) {
      return fail(ErrorCode::kInvalidArgument, "time does not grow at batch frame " + std::to_string(k));
    }
  }
  return {};
}

Status check_batch(const BatchProblem& batch) {
  if (batch.fixed_frames.empty() && batch.measured_poses.empty() && !batch.T_body_cam.empty()) {
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
  if (!(batch.scale.value > 0.0 && batch.scale.sigma >= 0.0)) {
    return fail(ErrorCode::kInvalidArgument, "scale of the batch problem must be positive, its sigma not negative");
  }
  if (Status turns = check_turns(batch.turns, batch.T_body_cam.size()); !turns) {
    return turns;
  }
  if (Status motion = check_motion(batch); !motion) {
    return motion;
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

/// A Ceres problem and the data it refers to.
class Assembly {
 public:
  Assembly(const CeresBundleConfig& config, BatchProblem& batch)
      : batch_(batch), poses_(batch.T_body_cam.size()), loss_(config.robust_threshold_sigmas) {
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      from_pose(batch.T_body_cam[k].inverse(), poses_[k].data());
    }
    add_observations();
    add_motion();
    add_scale();
    const std::vector<bool> fixed = fixed_frames(batch);
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      if (problem_.HasParameterBlock(block(k))) {
        problem_.SetManifold(block(k), &manifold_);
        ordering_->AddElementToGroup(block(k), 1);
        if (fixed[k]) {
          problem_.SetParameterBlockConstant(block(k));
        }
      }
    }
  }

  [[nodiscard]] ceres::Problem& problem() noexcept { return problem_; }
  [[nodiscard]] const std::shared_ptr<ceres::ParameterBlockOrdering>& ordering() const noexcept { return ordering_; }
  /// Covariances of the free poses at the present state, in the order of frames.
  [[nodiscard]] std::vector<Matrix6d> free_pose_covariances() {
    ceres::Problem::EvaluateOptions options;
    std::vector<double*>& blocks = options.parameter_blocks;
    for (Eigen::Vector3d& point : batch_.points_m) {
      if (problem_.HasParameterBlock(point.data())) {
        blocks.push_back(point.data());
      }
    }
    const std::size_t points = blocks.size();
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      if (is_free(k)) {
        blocks.push_back(block(k));
      }
    }
    ceres::CRSMatrix jacobian;
    problem_.Evaluate(options, nullptr, nullptr, nullptr, &jacobian);
    return marginal_pose_covariances(jacobian, points, blocks.size() - points);
  }
  [[nodiscard]] bool is_free(std::size_t frame) {
    return problem_.HasParameterBlock(block(frame)) && !problem_.IsParameterBlockConstant(block(frame));
  }
  void take_poses() {
    const std::vector<bool> fixed = fixed_frames(batch_);
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      if (!fixed[k] && problem_.HasParameterBlock(block(k))) {
        batch_.T_body_cam[k] = to_pose(block(k)).inverse();
      }
    }
  }

 private:
  [[nodiscard]] double* block(std::size_t frame) noexcept { return poses_[frame].data(); }
  [[nodiscard]] WorldPose world_pose(std::size_t frame) const { return {batch_.motion->T_world_cam[frame]}; }
  [[nodiscard]] double seconds_to(std::size_t frame) const {
    const auto& times = batch_.motion->timestamps_ns;
    return 1e-9 * static_cast<double>(times[frame] - times[frame - 1]);
  }

  // Points are eliminated before poses.
  void add_observations() {
    for (const BatchObservation& seen : batch_.observations) {
      double* point = batch_.points_m[seen.point].data();
      problem_.AddResidualBlock(new ReprojectionCost(batch_.geometry, seen.observation), &loss_, block(seen.frame),
                                point);
      ordering_->AddElementToGroup(point, 0);
    }
  }

  void add_motion() {
    for (std::size_t k = 1; k < batch_.turns.size(); ++k) {
      problem_.AddResidualBlock(new TurnCost(batch_.turns[k]), &turn_loss_, block(k - 1), block(k));
    }
    for (const BatchStep& step : batch_.measured_steps) {
      problem_.AddResidualBlock(new StepCost(step), nullptr, block(step.from), block(step.to), &batch_.scale.value);
    }
    for (const BatchStep& loop : batch_.loops) {
      problem_.AddResidualBlock(new StepCost(loop), &pose_loss_, block(loop.from), block(loop.to), &batch_.scale.value);
    }
    for (const BatchFix& fix : batch_.fixes) {
      problem_.AddResidualBlock(new FixCost(fix), &pose_loss_, block(fix.map), block(fix.before), block(fix.after));
    }
    for (const BatchPose& pose : batch_.measured_poses) {
      problem_.AddResidualBlock(new PoseCost(world_pose(pose.frame), pose.T_world_body, pose.inverse_sigma),
                                &pose_loss_, block(pose.frame));
    }
    for (std::size_t k = 1; batch_.motion && k < poses_.size(); ++k) {
      add_expected_motion(*batch_.motion, k);
    }
  }

  void add_scale() {
    double* scale = &batch_.scale.value;
    if (!problem_.HasParameterBlock(scale)) {
      return;
    }
    ordering_->AddElementToGroup(scale, 1);
    if (batch_.scale.sigma > 0.0) {
      problem_.AddResidualBlock(new ScaleCost(batch_.scale.sigma), nullptr, scale);
    } else {
      problem_.SetParameterBlockConstant(scale);
    }
  }

  void add_expected_motion(const BatchMotion& motion, std::size_t k) {
    Vector6d inverse_velocity = motion.rest_velocity.cwiseInverse();
    if (motion.at_rest[k] == 0) {
      inverse_velocity << Eigen::Vector3d::Constant(1.0 / motion.turn_rate_radps), Eigen::Vector3d::Zero();
    }
    if (!inverse_velocity.isZero(0.0)) {
      problem_.AddResidualBlock(new VelocityCost({world_pose(k - 1), world_pose(k)}, seconds_to(k), inverse_velocity),
                                &velocity_loss_, block(k - 1), block(k));
    }
    if (k >= 2) {
      const Matrix6d weight = motion.prior.root_information(
          motion.vertical, world_pose(k - 1).of(block(k - 1)).rotation, 0.5 * (seconds_to(k - 1) + seconds_to(k)));
      problem_.AddResidualBlock(new SteadyCost({world_pose(k - 2), world_pose(k - 1), world_pose(k)}, seconds_to(k - 1),
                                               seconds_to(k), weight),
                                nullptr, block(k - 2), block(k - 1), block(k));
    }
  }

  static ceres::Problem::Options problem_options() {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.disable_all_safety_checks = true;
    return options;
  }

  BatchProblem& batch_;
  std::vector<PoseBlock> poses_;
  ceres::CauchyLoss loss_;
  ceres::CauchyLoss turn_loss_{kTurnThreshold};
  ceres::CauchyLoss velocity_loss_{1.0};
  ceres::HuberLoss pose_loss_{3.0};
  LeftPerturbation manifold_;
  ceres::Problem problem_{problem_options()};
  std::shared_ptr<ceres::ParameterBlockOrdering> ordering_ = std::make_shared<ceres::ParameterBlockOrdering>();
};

class ContinuationCheck final : public ceres::IterationCallback {
 public:
  explicit ContinuationCheck(const std::function<bool()>& keep_going) : keep_going_(keep_going) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& /*summary*/) override {
    return keep_going_() ? ceres::SOLVER_CONTINUE : ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }

 private:
  const std::function<bool()>& keep_going_;
};

Result<BundleSummary> solve(const CeresBundleConfig& config, BatchProblem& batch) {
  Assembly assembly(config, batch);
  ceres::Solver::Options options = solver_options(config, batch);
  options.linear_solver_ordering = assembly.ordering();
  ContinuationCheck callback(config.keep_going);
  if (config.keep_going) {
    options.callbacks.push_back(&callback);
  }
  ceres::Solver::Summary report;
  ceres::Solve(options, &assembly.problem(), &report);
  if (!report.IsSolutionUsable()) {
    return fail(ErrorCode::kInternal, "batch refinement failed: " + report.message);
  }
  assembly.take_poses();
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
  const bool is_bound = !problem.observations.empty() || !problem.measured_poses.empty() || !problem.loops.empty() ||
                        !problem.fixes.empty();
  if (!is_bound || !has_free_frame(problem)) {
    BundleSummary nothing_to_do;
    nothing_to_do.converged = true;
    return nothing_to_do;
  }
  return solve(config_, problem);
}

Result<std::vector<Matrix6d>> CeresBundleAdjuster::pose_covariances(BatchProblem& problem) const {
  const ForeignCall foreign;
  if (Status valid = check_batch(problem); !valid) {
    return Unexpected(valid.error());
  }
  if (problem.T_body_cam.size() > kMaxCovarianceFrames) {
    return fail(ErrorCode::kInvalidArgument, "covariances of " + std::to_string(problem.T_body_cam.size()) +
                                                 " poses are more than " + std::to_string(kMaxCovarianceFrames));
  }
  Assembly assembly(config_, problem);
  const std::vector<Matrix6d> free = assembly.free_pose_covariances();
  std::vector<Matrix6d> covariances(problem.T_body_cam.size(), Matrix6d::Zero());
  std::size_t next = 0;
  for (std::size_t k = 0; k < covariances.size(); ++k) {
    if (assembly.is_free(k)) {
      covariances[k] = free[next++];
    }
  }
  return covariances;
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

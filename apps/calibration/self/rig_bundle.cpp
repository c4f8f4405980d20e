#include "rig_bundle.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <ceres/ceres.h>

#include "rig_residuals.hpp"

namespace kinetrace::self_calibration {
namespace {

LeftResidual view_residual(const RigModel& rig, const BundlePoint& point, const Observation& seen, double sigma_px) {
  return {rig.size, point.T_host_world.inverse(), seen.raw_px, 1.0 / (sigma_px * point.sigma_scale)};
}

/// All parameters in one array: Ceres orders blocks by address and sums in that order, so separate allocations would
/// make results differ between runs.
class Blocks {
 public:
  Blocks(const RigModel& rig, std::span<const BundleWindow> windows) {
    for (const LensBlock& lens : rig.lens) {
      append(lens);
    }
    append(rig.mount);
    for (const BundleWindow& window : windows) {
      poses_.push_back(values_.size());
      for (const PoseBlock& pose : window.poses) {
        append(pose);
      }
      points_.push_back(values_.size());
      for (const BundlePoint& point : window.points) {
        append(point.ray_and_inverse_depth);
      }
    }
  }

  double* lens(std::size_t view) { return &values_[view * kLensSize]; }
  double* mount() { return lens(2); }  // after both lenses
  double* pose(std::size_t window, std::size_t frame) { return &values_[poses_[window] + 6 * frame]; }
  double* point(std::size_t window, std::size_t point) { return &values_[points_[window] + 3 * point]; }

  void write(RigModel& rig, std::span<BundleWindow> windows) {
    std::copy_n(lens(0), kLensSize, rig.lens[0].begin());
    std::copy_n(lens(1), kLensSize, rig.lens[1].begin());
    std::copy_n(mount(), kMountSize, rig.mount.begin());
    for (std::size_t w = 0; w < windows.size(); ++w) {
      for (std::size_t k = 0; k < windows[w].poses.size(); ++k) {
        std::copy_n(pose(w, k), 6, windows[w].poses[k].begin());
      }
      for (std::size_t i = 0; i < windows[w].points.size(); ++i) {
        std::copy_n(point(w, i), 3, windows[w].points[i].ray_and_inverse_depth.begin());
      }
    }
  }

 private:
  template <std::size_t Size>
  void append(const std::array<double, Size>& block) {
    values_.insert(values_.end(), block.begin(), block.end());
  }

  std::vector<double> values_;
  std::vector<std::size_t> poses_;   ///< First pose of each window.
  std::vector<std::size_t> points_;  ///< First point of each window.
};

class BundleProblem {
 public:
  BundleProblem(const RigModel& rig, std::span<const BundleWindow> windows, const BundleOptions& options)
      : options_(options), blocks_(rig, windows), loss_(options.robust_sigmas), problem_(problem_options()) {
    add_priors();
    for (std::size_t w = 0; w < windows.size(); ++w) {
      add_window(rig, windows[w], w);
    }
    for (double* block : {blocks_.lens(0), blocks_.lens(1), blocks_.mount()}) {
      ordering_->AddElementToGroup(block, 1);
      if (options.rig_fixed) {
        problem_.SetParameterBlockConstant(block);
      }
    }
  }

  ceres::Solver::Summary solve(ceres::Solver::Options solver) {
    solver.linear_solver_ordering = ordering_;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem_, &summary);
    return summary;
  }

  Blocks& blocks() { return blocks_; }

 private:
  static ceres::Problem::Options problem_options() {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.disable_all_safety_checks = true;
    return options;
  }

  void add_priors() {
    const LensPriors& priors = options_.priors;
    for (std::size_t view = 0; view < 2; ++view) {
      problem_.AddResidualBlock(new LensPrior::Cost(new LensPrior{priors.sigma}), nullptr, blocks_.lens(view));
    }
    problem_.AddResidualBlock(new LensDifferencePrior::Cost(new LensDifferencePrior{priors.sigma_between}), nullptr,
                              blocks_.lens(0), blocks_.lens(1));
    problem_.AddResidualBlock(new MountPrior::Cost(new MountPrior{priors.sigma_mount}), nullptr, blocks_.mount());
  }

  void add_window(const RigModel& rig, const BundleWindow& window, std::size_t w) {
    for (std::size_t i = 0; i < window.points.size(); ++i) {
      if (!window.points[i].used) {
        continue;
      }
      for (const Observation& seen : window.points[i].observations) {
        add_observation(rig, window.points[i], seen, blocks_.pose(w, seen.frame), blocks_.point(w, i));
      }
      ordering_->AddElementToGroup(blocks_.point(w, i), 0);
    }
    for (std::size_t k = 0; k < window.poses.size(); ++k) {
      if (problem_.HasParameterBlock(blocks_.pose(w, k))) {
        ordering_->AddElementToGroup(blocks_.pose(w, k), 1);
      }
    }
    if (problem_.HasParameterBlock(blocks_.pose(w, 0))) {
      problem_.SetParameterBlockConstant(blocks_.pose(w, 0));
    }
  }

  void add_observation(const RigModel& rig, const BundlePoint& point, const Observation& seen, double* pose,
                       double* place) {
    const LeftResidual left = view_residual(rig, point, seen, options_.sigma_px);
    if (seen.view == 0) {
      problem_.AddResidualBlock(new LeftResidual::Cost(new LeftResidual(left)), &loss_, blocks_.lens(0), pose, place);
    } else {
      problem_.AddResidualBlock(new RightResidual::Cost(new RightResidual{left, rig.baseline_m}), &loss_,
                                blocks_.lens(1), blocks_.mount(), pose, place);
    }
  }

  const BundleOptions& options_;
  Blocks blocks_;
  ceres::CauchyLoss loss_;
  ceres::Problem problem_;
  std::shared_ptr<ceres::ParameterBlockOrdering> ordering_ = std::make_shared<ceres::ParameterBlockOrdering>();
};

ceres::Solver::Options solver_options(const BundleOptions& options) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.max_num_iterations = options.iterations;
  solver.num_threads = options.threads;
  solver.function_tolerance = options.tolerance;
  solver.logging_type = ceres::SILENT;
  return solver;
}

/// Derivatives of one residual by rig, pose and point.
struct Linearisation {
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, kRigSize> by_rig = Eigen::Matrix<double, 2, kRigSize>::Zero();
  Eigen::Matrix<double, 2, 6, Eigen::RowMajor> by_pose;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_point;
};

Linearisation linearise(const RigModel& rig, const BundleWindow& window, const BundlePoint& point,
                        const Observation& seen, const BundleOptions& options) {
  Linearisation at;
  Eigen::Matrix<double, 2, kLensSize, Eigen::RowMajor> by_lens;
  Eigen::Matrix<double, 2, kMountSize, Eigen::RowMajor> by_mount;
  const LeftResidual left = view_residual(rig, point, seen, options.sigma_px);
  const double* pose = window.poses[seen.frame].data();
  const double* place = point.ray_and_inverse_depth.data();
  if (seen.view == 0) {
    const std::array<const double*, 3> parameters{rig.lens[0].data(), pose, place};
    std::array<double*, 3> jacobians{by_lens.data(), at.by_pose.data(), at.by_point.data()};
    LeftResidual::Cost(new LeftResidual(left)).Evaluate(parameters.data(), at.residual.data(), jacobians.data());
    at.by_rig.leftCols<kLensSize>() = by_lens;
  } else {
    const std::array<const double*, 4> parameters{rig.lens[1].data(), rig.mount.data(), pose, place};
    std::array<double*, 4> jacobians{by_lens.data(), by_mount.data(), at.by_pose.data(), at.by_point.data()};
    RightResidual::Cost(new RightResidual{left, rig.baseline_m})
        .Evaluate(parameters.data(), at.residual.data(), jacobians.data());
    at.by_rig.middleCols<kLensSize>(kLensSize) = by_lens;
    at.by_rig.rightCols<kMountSize>() = by_mount;
  }
  if (seen.frame == 0) {
    at.by_pose.setZero();
  }
  // The Cauchy loss as a weight of iteratively reweighted least squares.
  const double s = options.robust_sigmas;
  const double weight = std::sqrt(1.0 / (1.0 + at.residual.squaredNorm() / (s * s)));
  at.residual *= weight;
  at.by_rig *= weight;
  at.by_pose *= weight;
  at.by_point *= weight;
  return at;
}

/// Adds a point's information about rig and poses, with the point eliminated.
void add_point(const RigModel& rig, const BundleWindow& window, const BundlePoint& point, const BundleOptions& options,
               Eigen::MatrixXd& normal, Eigen::VectorXd& gradient) {
  const Eigen::Index size = normal.rows();
  Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
  Eigen::Vector3d own_gradient = Eigen::Vector3d::Zero();
  Eigen::MatrixXd mixed = Eigen::MatrixXd::Zero(size, 3);
  for (const Observation& seen : point.observations) {
    const Linearisation at = linearise(rig, window, point, seen, options);
    const Eigen::Index pose = kRigSize + 6 * static_cast<Eigen::Index>(seen.frame);
    normal.topLeftCorner<kRigSize, kRigSize>() += at.by_rig.transpose() * at.by_rig;
    normal.block<kRigSize, 6>(0, pose) += at.by_rig.transpose() * at.by_pose;
    normal.block<6, kRigSize>(pose, 0) += at.by_pose.transpose() * at.by_rig;
    normal.block<6, 6>(pose, pose) += at.by_pose.transpose() * at.by_pose;
    gradient.head<kRigSize>() += at.by_rig.transpose() * at.residual;
    gradient.segment<6>(pose) += at.by_pose.transpose() * at.residual;
    mixed.topRows<kRigSize>() += at.by_rig.transpose() * at.by_point;
    mixed.middleRows<6>(pose) += at.by_pose.transpose() * at.by_point;
    own += at.by_point.transpose() * at.by_point;
    own_gradient += at.by_point.transpose() * at.residual;
  }
  own.diagonal().array() += 1e-9 * own.trace();
  const Eigen::Matrix3d inverse = own.inverse();
  normal.noalias() -= mixed * inverse * mixed.transpose();
  gradient.noalias() -= mixed * (inverse * own_gradient);
}

}  // namespace

Result<BundleResult> adjust(RigModel& rig, std::span<BundleWindow> windows, const BundleOptions& options) {
  BundleProblem problem(rig, windows, options);
  const ceres::Solver::Summary summary = problem.solve(solver_options(options));
  if (!summary.IsSolutionUsable()) {
    return fail(ErrorCode::kInternal, "self-calibration: bundle adjustment failed: " + summary.message);
  }
  problem.blocks().write(rig, windows);
  return BundleResult{summary.final_cost, static_cast<int>(summary.iterations.size()) - 1,
                      summary.termination_type == ceres::CONVERGENCE};
}

Eigen::Vector2d residual_px(const RigModel& rig, const BundleWindow& window, const BundlePoint& point,
                            const Observation& seen) {
  const LeftResidual left = view_residual(rig, point, seen, 1.0 / point.sigma_scale);
  const double* pose = window.poses[seen.frame].data();
  Eigen::Vector2d residual;
  if (seen.view == 0) {
    left(rig.lens[0].data(), pose, point.ray_and_inverse_depth.data(), residual.data());
  } else {
    RightResidual{left, rig.baseline_m}(rig.lens[1].data(), rig.mount.data(), pose, point.ray_and_inverse_depth.data(),
                                        residual.data());
  }
  return residual;
}

RigInformation rig_information(const RigModel& rig, const BundleWindow& window, const BundleOptions& options) {
  const Eigen::Index size = kRigSize + 6 * static_cast<Eigen::Index>(window.poses.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
  for (const BundlePoint& point : window.points) {
    if (point.used) {
      add_point(rig, window, point, options, normal, gradient);
    }
  }
  const Eigen::Index poses = size - kRigSize;
  // The first pose is fixed, and the pose of a frame without points is undetermined: unit diagonals keep the matrix
  // regular.
  Eigen::MatrixXd own = normal.bottomRightCorner(poses, poses);
  own.diagonal().array() += 1e-6;
  const Eigen::LDLT<Eigen::MatrixXd> factor(own);
  const Eigen::MatrixXd mixed = normal.bottomLeftCorner(poses, kRigSize);
  RigInformation information;
  information.normal = normal.topLeftCorner<kRigSize, kRigSize>() - mixed.transpose() * factor.solve(mixed);
  information.gradient = gradient.head<kRigSize>() - mixed.transpose() * factor.solve(gradient.tail(poses));
  return information;
}

RigInformation prior_information(const RigModel& rig, const LensPriors& priors) {
  RigInformation information;
  for (int i = 0; i < kLensSize; ++i) {
    const auto p = static_cast<std::size_t>(i);
    const double own = 1.0 / (priors.sigma[p] * priors.sigma[p]);
    const double between = 1.0 / (priors.sigma_between[p] * priors.sigma_between[p]);
    const double difference = rig.lens[1][p] - rig.lens[0][p];
    information.normal(i, i) += own + between;
    information.normal(kLensSize + i, kLensSize + i) += own + between;
    information.normal(i, kLensSize + i) -= between;
    information.normal(kLensSize + i, i) -= between;
    information.gradient[i] += own * rig.lens[0][p] - between * difference;
    information.gradient[kLensSize + i] += own * rig.lens[1][p] + between * difference;
  }
  for (int i = 0; i < kMountSize; ++i) {
    const double own = 1.0 / (priors.sigma_mount * priors.sigma_mount);
    information.normal(2 * kLensSize + i, 2 * kLensSize + i) += own;
    information.gradient[2 * kLensSize + i] += own * rig.mount[static_cast<std::size_t>(i)];
  }
  return information;
}

}  // namespace kinetrace::self_calibration

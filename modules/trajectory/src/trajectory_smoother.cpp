#include "kinetrace/trajectory/trajectory_smoother.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "kinetrace/core/body_velocity.hpp"
#include "velocity_fit.hpp"

namespace kinetrace::trajectory {
namespace {

constexpr int kIterations = 4;
constexpr double kConverged = 1e-6;  // rad or m
// Huber threshold: root of the 99 % quantile of chi-square with six degrees of freedom. A loss that rejects outliers
// altogether could leave the path to the prior alone.
constexpr double kHuber = 4.1;
// Lower bounds of a pose's standard deviations: its covariance omits the correlated errors of the reconstruction.
constexpr double kRotationFloor_rad = 5e-4;
constexpr double kPositionFloor_m = 2e-3;
/// Errors of successive poses of a reconstruction are correlated: so many count as one beside the smoothness.
constexpr double kCorrelatedPoses = 2.0;
constexpr double kMinStep_s = 1e-4;

double seconds(const PathNode& from, const PathNode& to) {
  return std::max(1e-9 * static_cast<double>(to.timestamp_ns - from.timestamp_ns), kMinStep_s);
}

/// Variance from which a rotation counts as not measured.
constexpr double kUnknownRotation_rad2 = 0.5;

bool rotation_unknown(const PathNode& node) {
  return node.covariance.topLeftCorner<3, 3>().trace() > 3.0 * kUnknownRotation_rad2;
}

/// Covariance of a pose whose rotation is held: that of its position given the rotation.
Matrix6d given_rotation(const Matrix6d& covariance) {
  const Eigen::Matrix3d with_rotation = covariance.topRightCorner<3, 3>();
  Matrix6d given = Matrix6d::Zero();
  given.topLeftCorner<3, 3>().diagonal().setConstant(kRotationFloor_rad * kRotationFloor_rad);
  given.bottomRightCorner<3, 3>() =
      covariance.bottomRightCorner<3, 3>() -
      with_rotation.transpose() * covariance.topLeftCorner<3, 3>().ldlt().solve(with_rotation);
  return given;
}

BodyVelocity differentiated_velocity(const PathNode& a, const PathNode& b) {
  return kinetrace::body_velocity(a.smoothed, b.smoothed, seconds(a, b));
}

Matrix6d rest_root_information() {
  Vector6d root;
  root << Eigen::Vector3d::Constant(1.0 / kRestTurnSigma_radps), Eigen::Vector3d::Constant(1.0 / kRestSpeedSigma_mps);
  return root.asDiagonal();
}

}  // namespace

Vector6d body_velocity(const PathNode& from, const PathNode& to) {
  return differentiated_velocity(from, to).value;
}

TrajectorySmoother::TrajectorySmoother(const TrajectoryConfig& config, std::size_t max_nodes, Arena& arena)
    : prior_(config.motion), rows_(arena.take<BlockRow>(max_nodes)) {}

void TrajectorySmoother::add_measurement(const PathNode& node, BlockRow& row) const noexcept {
  Matrix6d covariance = kCorrelatedPoses * node.covariance;
  covariance.diagonal().head<3>().array() += kRotationFloor_rad * kRotationFloor_rad;
  covariance.diagonal().tail<3>().array() += kPositionFloor_m * kPositionFloor_m;
  Vector6d error;
  error << so3_log(node.smoothed.rotation * node.measured.rotation.transpose()),
      node.smoothed.translation - node.measured.translation;
  const Eigen::LDLT<Matrix6d> ldlt(covariance);
  const double distance = std::sqrt(std::max(error.dot(ldlt.solve(error)), 0.0));
  const double weight = distance <= kHuber ? 1.0 : kHuber / distance;
  const Matrix6d information = weight * ldlt.solve(Matrix6d::Identity());
  row.diagonal += information;
  row.rhs -= information * error;
}

void TrajectorySmoother::add_smoothness(std::span<const PathNode> path, std::size_t middle, std::size_t fixed,
                                        const std::optional<Eigen::Vector3d>& vertical) noexcept {
  const BodyVelocity before = differentiated_velocity(path[middle - 1], path[middle]);
  const BodyVelocity after = differentiated_velocity(path[middle], path[middle + 1]);
  const double span_s = 0.5 * (seconds(path[middle - 1], path[middle]) + seconds(path[middle], path[middle + 1]));
  const Matrix6d weight = prior_.root_information(vertical, path[middle].smoothed.rotation, span_s);

  const Vector6d error = weight * (after.value - before.value);
  const std::array<Matrix6d, 3> jacobian = {weight * -before.by_from, weight * (after.by_from - before.by_to),
                                            weight * after.by_to};
  for (std::size_t i = 0; i < jacobian.size(); ++i) {
    const std::size_t node = middle - 1 + i;
    if (node < fixed) {
      continue;
    }
    BlockRow& row = rows_[node - fixed];
    row.diagonal += jacobian[i].transpose() * jacobian[i];
    row.rhs -= jacobian[i].transpose() * error;
    if (i + 1 < jacobian.size()) {
      row.next += jacobian[i].transpose() * jacobian[i + 1];
    }
    if (i + 2 < jacobian.size()) {
      row.after_next += jacobian[i].transpose() * jacobian[i + 2];
    }
  }
}

void TrajectorySmoother::add_velocity(std::span<const PathNode> path, std::size_t to, std::size_t fixed,
                                      const Matrix6d& weight) noexcept {
  const BodyVelocity velocity = differentiated_velocity(path[to - 1], path[to]);
  const Vector6d error = weight * velocity.value;
  const Matrix6d by_to = weight * velocity.by_to;
  BlockRow& row = rows_[to - fixed];
  row.diagonal += by_to.transpose() * by_to;
  row.rhs -= by_to.transpose() * error;
  if (to - 1 < fixed) {
    return;
  }
  const Matrix6d by_from = weight * velocity.by_from;
  BlockRow& before = rows_[to - 1 - fixed];
  before.diagonal += by_from.transpose() * by_from;
  before.rhs -= by_from.transpose() * error;
  before.next += by_from.transpose() * by_to;
}

void TrajectorySmoother::add_velocity_prior(std::span<const PathNode> path, std::size_t fixed,
                                            const PathPrior& prior) noexcept {
  if (prior.at_rest) {
    for (std::size_t k = std::max<std::size_t>(fixed, 1); k < path.size(); ++k) {
      add_velocity(path, k, fixed, rest_root_information());
    }
  } else if (fixed <= 1 && path.size() > 1) {
    Matrix6d root = Matrix6d::Zero();
    const Eigen::Matrix3d to_body = path[0].smoothed.rotation.transpose();
    root.bottomRightCorner<3, 3>() =
        to_body * prior_.velocity_root_information(prior.vertical, kSpeedPriorSigma_mps) * to_body.transpose();
    add_velocity(path, 1, fixed, root);
  }
}

void TrajectorySmoother::assemble(std::span<const PathNode> path, std::size_t fixed, const PathPrior& prior) noexcept {
  for (std::size_t k = fixed; k < path.size(); ++k) {
    BlockRow& row = rows_[k - fixed];
    row = {Matrix6d::Zero(), Matrix6d::Zero(), Matrix6d::Zero(), Vector6d::Zero()};
    add_measurement(path[k], row);
  }
  add_velocity_prior(path, fixed, prior);
  for (std::size_t middle = 1; middle + 1 < path.size(); ++middle) {
    if (middle + 1 >= fixed) {
      add_smoothness(path, middle, fixed, prior.vertical);
    }
  }
}

void TrajectorySmoother::solve(std::size_t count) noexcept {
  // Forward: eliminate node k from its two successors. The inverse of its block replaces the block.
  for (std::size_t k = 0; k < count; ++k) {
    BlockRow& row = rows_[k];
    row.diagonal = Matrix6d(row.diagonal.ldlt().solve(Matrix6d::Identity()));
    if (k + 1 < count) {
      const Matrix6d factor = row.next.transpose() * row.diagonal;
      rows_[k + 1].diagonal -= factor * row.next;
      rows_[k + 1].next -= factor * row.after_next;
      rows_[k + 1].rhs -= factor * row.rhs;
    }
    if (k + 2 < count) {
      const Matrix6d factor = row.after_next.transpose() * row.diagonal;
      rows_[k + 2].diagonal -= factor * row.after_next;
      rows_[k + 2].rhs -= factor * row.rhs;
    }
  }
  for (std::size_t k = count; k-- > 0;) {
    BlockRow& row = rows_[k];
    if (k + 1 < count) {
      row.rhs -= row.next * rows_[k + 1].rhs;
    }
    if (k + 2 < count) {
      row.rhs -= row.after_next * rows_[k + 2].rhs;
    }
    row.rhs = Vector6d(row.diagonal * row.rhs);
  }
}

void TrajectorySmoother::smooth(std::span<PathNode> path, std::size_t fixed, const PathPrior& prior) noexcept {
  for (PathNode& node : path.subspan(std::min(fixed, path.size()))) {
    node.smoothed = node.measured;
  }
  if (path.size() < 2 || path.size() <= fixed) {
    return;
  }
  if (std::all_of(path.begin(), path.end(), rotation_unknown)) {
    // The path must not determine the rotation of an object whose rotation was never measured.
    for (PathNode& node : path) {
      node.covariance = given_rotation(node.covariance);
    }
  }
  const std::size_t count = path.size() - fixed;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    assemble(path, fixed, prior);
    solve(count);
    double largest = 0.0;
    for (std::size_t k = 0; k < count; ++k) {
      const Vector6d& step = rows_[k].rhs;
      Se3& pose = path[fixed + k].smoothed;
      pose.rotation = orthonormalised(so3_exp(step.head<3>()) * pose.rotation);
      pose.translation += step.tail<3>();
      largest = std::max(largest, step.cwiseAbs().maxCoeff());
    }
    if (largest < kConverged) {
      break;
    }
  }
}

}  // namespace kinetrace::trajectory

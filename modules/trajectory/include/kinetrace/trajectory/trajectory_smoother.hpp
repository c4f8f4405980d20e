// Fixed-lag smoothing of one object's path over the window.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/trajectory/trajectory_config.hpp"

namespace kinetrace::trajectory {

/// One frame of the path.
struct PathNode {
  std::int64_t timestamp_ns = 0;
  Se3 measured;                                ///< T_world_obj of this frame alone.
  Matrix6d covariance = Matrix6d::Identity();  ///< Of (rotation about the world's axes in rad, position in m).
  Se3 smoothed;                                ///< Output; input for fixed nodes.
};

/// What is known of a whole path.
struct PathPrior {
  /// Adds a prior of nearly zero velocity, so that the object does not drift with the errors of its reconstruction.
  bool at_rest = false;
  std::optional<Eigen::Vector3d> vertical = std::nullopt;  ///< Normal of the ground, world axes, if known.
};

/// Velocity of the body in its own axes on the way from one smoothed node to the next: (rad/s, m/s).
[[nodiscard]] Vector6d body_velocity(const PathNode& from, const PathNode& to);

/// Fixed-lag smoother of SE(3) poses under a white-noise-on-acceleration prior (MotionPrior; on SE(3) as Anderson and
/// Barfoot, IROS 2015): between frames the velocity of the body in its own axes changes no more than a vehicle can
/// brake or steer, independent of the camera's rate, and the first one has a prior, wide along the ground. Well
/// measured poses hardly move; uncertain ones (far away, truncated, predicted) follow their neighbours. A Huber loss
/// keeps a single outlier from bending the path.
///
/// Gauss-Newton on the pentadiagonal normal equations of 6 x 6 blocks: linear in the number of nodes.
class TrajectorySmoother {
 public:
  /// Memory: 1.1 kB per node. The arena may turn out exhausted.
  TrajectorySmoother(const TrajectoryConfig& config, std::size_t max_nodes, Arena& arena);

  /// `path`: oldest first, times ascending, at most `max_nodes`. The first `fixed` nodes are final and only constrain
  /// the motion. A single node is returned unchanged.
  void smooth(std::span<PathNode> path, std::size_t fixed, const PathPrior& prior = {}) noexcept;

 private:
  /// Row k of the upper triangle: blocks (k, k), (k, k + 1), (k, k + 2), and the gradient.
  struct BlockRow {
    Matrix6d diagonal;
    Matrix6d next;
    Matrix6d after_next;
    Vector6d rhs;
  };

  void assemble(std::span<const PathNode> path, std::size_t fixed, const PathPrior& prior) noexcept;
  void add_measurement(const PathNode& node, BlockRow& row) const noexcept;
  void add_velocity(std::span<const PathNode> path, std::size_t to, std::size_t fixed, const Matrix6d& weight) noexcept;
  /// Rest in every interval, or the first velocity along the ground.
  void add_velocity_prior(std::span<const PathNode> path, std::size_t fixed, const PathPrior& prior) noexcept;
  void add_smoothness(std::span<const PathNode> path, std::size_t middle, std::size_t fixed,
                      const std::optional<Eigen::Vector3d>& vertical) noexcept;
  /// Solves in place; the perturbation of node k is in rows_[k].rhs.
  void solve(std::size_t count) noexcept;

  MotionPrior prior_;
  std::span<BlockRow> rows_;
};

}  // namespace kinetrace::trajectory

// Upright 3-D box of an object from its points.
#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/body.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/trajectory/trajectory_config.hpp"

namespace kinetrace::trajectory {

/// Box in the object frame, which was parallel to the world's at birth: centre, size along its own axes, yaw about y.
/// Grows with what is seen over the object's life, at a bounded rate, so that it never jumps.
class BoxEstimator {
 public:
  /// `arena` gives room to sort `max_points` coordinates.
  BoxEstimator(const TrajectoryConfig& config, std::size_t max_points, Arena& arena);
  void reset() noexcept;
  [[nodiscard]] bool known() const noexcept { return known_; }
  /// `yaw_rad`: heading in the object frame when the object moves; NaN when unknown (then the points' main horizontal
  /// direction).
  void update(std::span<const BodyPoint> points, double yaw_rad) noexcept;
  [[nodiscard]] const Box3& box_in_object() const noexcept { return box_; }
  [[nodiscard]] Box3 box_in_world(const Se3& T_world_obj) const noexcept;

 private:
  TrajectoryConfig config_;
  std::span<float> scratch_;
  bool known_ = false;
  Box3 box_;
};

}  // namespace kinetrace::trajectory

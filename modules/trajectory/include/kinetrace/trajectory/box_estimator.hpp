// Upright 3-D box of an object from its points.
#pragma once

#include <cstddef>
#include <span>
#include <utility>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/body.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/trajectory/trajectory_config.hpp"

namespace kinetrace::trajectory {

/// Box in the object frame, which was parallel to the world's at birth: centre, size along its own axes, yaw about y.
///
/// The extent along each axis is that of the points between two percentiles; points beyond a gap are left out. It grows
/// with what is seen over the object's life, at a bounded rate, and shrinks much more slowly, so that the box neither
/// jumps nor forgets the sides that are out of view. It turns at a bounded rate too; turns by quarters relabel length
/// and width.
class BoxEstimator {
 public:
  /// `arena` gives room to sort `max_points` coordinates; of more points, evenly spaced ones are used.
  BoxEstimator(const TrajectoryConfig& config, std::size_t max_points, Arena& arena);
  void reset() noexcept;
  /// Four points have been seen at once.
  [[nodiscard]] bool known() const noexcept { return known_; }
  /// `yaw_rad`: heading in the object frame when the object moves; NaN when unknown (then the last heading, or before
  /// any the points' main horizontal direction).
  void update(std::span<const BodyPoint> points, double yaw_rad) noexcept;
  [[nodiscard]] const Box3& box_in_object() const noexcept { return box_; }
  [[nodiscard]] Box3 box_in_world(const Se3& T_world_obj) const noexcept;

 private:
  /// Along one axis of the box, relative to the object's origin.
  struct Extent {
    double low_m = 0.0;
    double high_m = 0.0;
  };

  [[nodiscard]] std::size_t gather(std::span<const BodyPoint> points) noexcept;
  [[nodiscard]] std::pair<float, float> main_cluster(int axis) noexcept;
  [[nodiscard]] Extent measure(const Eigen::Vector3f& axis) noexcept;
  [[nodiscard]] double main_direction_rad() const noexcept;
  void turn_towards(double yaw_rad) noexcept;

  TrajectoryConfig config_;
  std::span<Eigen::Vector3f> points_;  ///< Of this update, without those far off.
  std::span<float> scratch_;
  std::size_t count_ = 0;
  bool known_ = false;
  bool heading_known_ = false;
  Box3 box_;
};

}  // namespace kinetrace::trajectory

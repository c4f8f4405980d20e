// The ground under the camera, from the background's points.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/body.hpp"
#include "kinetrace/core/se3.hpp"

namespace kinetrace::trajectory {

/// Plane `down.dot(p) = height_m`, `down` of unit length and away from the camera.
struct Ground {
  Eigen::Vector3d down = Eigen::Vector3d::UnitY();
  double height_m = 0.0;
  double sigma_m = 0.0;          ///< Of its height below the camera.
  double slope_sigma_rad = 0.0;  ///< Of `down`, about each axis.
  bool known = false;

  [[nodiscard]] std::optional<Eigen::Vector3d> vertical() const { return known ? std::optional(down) : std::nullopt; }
  /// The same in another frame, p_this = T_this_other p_other.
  [[nodiscard]] Ground in_frame(const Se3& T_this_other) const {
    const Eigen::Vector3d turned = T_this_other.rotation * down;
    return {turned, height_m + turned.dot(T_this_other.translation), sigma_m, slope_sigma_rad, known};
  }
};

/// RANSAC on the background's points: the plane with most inliers and few points below it, since nothing is visible
/// through the ground. A plane is kept until another one has a higher score, and follows the points by least squares.
/// `down` is within 70 degrees of the camera's y axis, which excludes walls. Deterministic.
class GroundEstimator {
 public:
  GroundEstimator(std::size_t max_points, Arena& arena);
  void reset() noexcept {
    ground_ = Ground{};
    averaged_ = 0;
  }
  /// `points` in the world; one call per frame.
  void update(std::span<const BodyPoint> points, const Se3& T_world_cam) noexcept;
  [[nodiscard]] const Ground& ground() const noexcept { return ground_; }

 private:
  struct Plane {
    Eigen::Vector3f down;
    float height_m = 0.F;
  };

  void gather(std::span<const BodyPoint> points, const Se3& T_world_cam) noexcept;
  [[nodiscard]] float tolerance_m(const Eigen::Vector3f& point_m) const noexcept;
  [[nodiscard]] float score(const Plane& plane) const noexcept;
  [[nodiscard]] bool plane_through(std::uint32_t seed, Plane& plane) const noexcept;
  void refine(const Plane& plane, const Se3& T_world_cam) noexcept;

  std::span<Eigen::Vector3f> points_;  ///< Relative to the camera, in the world's axes.
  std::size_t count_ = 0;
  Eigen::Vector3f camera_down_{0.F, 1.F, 0.F};
  Ground ground_;
  std::uint32_t frames_ = 0;
  int averaged_ = 0;  ///< Number of frames averaged in `down`.
};

}  // namespace kinetrace::trajectory

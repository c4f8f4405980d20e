// The ground plane, in disparity space.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::segmentation {

/// A plane of the world is a plane of (u, v, disparity). Found by RANSAC among the cells of a disparity map: the one
/// with most inliers, less the cells beyond it, since nothing is visible through the ground; the wall of a street, in
/// contrast, has many.
class GroundPlane {
 public:
  /// Log-likelihood ratio, see object_nats(), below which a point is ground.
  static constexpr float kGroundNats = -2.F;

  GroundPlane() = default;
  GroundPlane(const StereoGeometry& geometry, Arena& arena);

  void clear() noexcept { known_ = false; }
  /// Keeps the better of the plane so far and the best sample; unknown if none has enough inliers.
  void fit(ImageView<const float> cell_disparity_px, std::uint32_t seed);

  [[nodiscard]] bool known() const noexcept { return known_; }
  /// Unit normal, downwards, in the camera's axes; zero without a plane.
  [[nodiscard]] Eigen::Vector3f normal() const noexcept;
  /// log p(disparity | something 0.2 to 3 m above the ground) - log p(disparity | ground), at pixel (u, v) and with
  /// noise `sigma_px`; 0 without a plane.
  [[nodiscard]] float object_nats(float u, float v, float disparity_px, float sigma_px) const noexcept;
  /// False for the ground, and for points certainly higher above it than objects reach.
  [[nodiscard]] bool may_hold_object(float u, float v, float disparity_px, float sigma_px) const noexcept;

 private:
  [[nodiscard]] int score(const Eigen::Vector3f& plane, float tolerance_px) const;
  [[nodiscard]] float disparity_px(const Eigen::Vector3f& plane, float u, float v) const noexcept {
    return plane.x() * u + plane.y() * v + plane.z();
  }
  /// The plane's normal, times focal length and baseline over the camera's height above it.
  [[nodiscard]] Eigen::Vector3f scaled_normal(const Eigen::Vector3f& plane) const noexcept;
  [[nodiscard]] int points_below_horizon() const;
  void refine(float tolerance_px);

  StereoGeometry geometry_;
  // Cells used for fitting.
  FixedVector<float> u_px_;
  FixedVector<float> v_px_;
  FixedVector<float> disparity_px_;
  Eigen::Vector3f plane_{0.F, 0.F, 0.F};
  float camera_height_m_ = 0.F;
  bool known_ = false;
};

}  // namespace kinetrace::segmentation

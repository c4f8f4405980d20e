#include "kinetrace/sfm/triangulation.hpp"

#include <array>
#include <bit>
#include <cmath>

#include <Eigen/Cholesky>

namespace kinetrace::sfm {

std::optional<Eigen::Vector3d> triangulate(const StereoGeometry& geometry, std::span<const Se3> T_body_cam,
                                           std::span<const BundleObservation> row, std::uint32_t seen,
                                           double min_parallax_rad) {
  // Midpoint method: minimise the sum of squared distances to the rays, sum (I - d d^T) (x - c) = 0.
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  std::array<Eigen::Vector3d, std::size_t{2} * kMaxWindowFrames> rays;
  std::size_t count = 0;
  bool parallax = false;
  const double max_cosine = std::cos(min_parallax_rad);
  const auto add_ray = [&](const Eigen::Vector3d& center, const Eigen::Vector3d& ray) {
    const Eigen::Matrix3d projector = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    a += projector;
    b += projector * center;
    for (std::size_t i = 0; i < count && !parallax; ++i) {
      parallax = rays[i].dot(ray) <= max_cosine;
    }
    rays[count++] = ray;
  };
  for (std::uint32_t rest = seen; rest != 0; rest &= rest - 1) {
    const auto k = static_cast<std::size_t>(std::countr_zero(rest));
    const BundleObservation& o = row[k];
    const Se3& pose = T_body_cam[k];
    const double y = (double{o.v_px} - geometry.cy_px) / geometry.fy_px;
    add_ray(
        pose.translation,
        pose.rotation * Eigen::Vector3d((double{o.u_left_px} - geometry.cx_px) / geometry.fx_px, y, 1.0).normalized());
    if (!std::isnan(o.u_right_px)) {
      add_ray(pose * Eigen::Vector3d(geometry.baseline_m, 0.0, 0.0),
              pose.rotation *
                  Eigen::Vector3d((double{o.u_right_px} - geometry.cx_px) / geometry.fx_px, y, 1.0).normalized());
    }
  }
  if (!parallax) {
    return std::nullopt;
  }
  const Eigen::Vector3d point = a.ldlt().solve(b);
  if (!point.allFinite()) {
    return std::nullopt;
  }
  for (std::uint32_t rest = seen; rest != 0; rest &= rest - 1) {
    const Se3& pose = T_body_cam[static_cast<std::size_t>(std::countr_zero(rest))];
    if ((pose.inverse() * point).z() < 0.1) {
      return std::nullopt;
    }
  }
  return point;
}

}  // namespace kinetrace::sfm

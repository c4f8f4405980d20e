#include "lens.hpp"

#include <cmath>

#include <Eigen/LU>

namespace kinetrace::calibration {
namespace {

// Initial value by the lens without distortion, from which the iteration converges for every realistic lens.
std::optional<Eigen::Vector2d> undistorted_start(const hal::CameraModel& camera, const Eigen::Vector2d& px) {
  const Eigen::Vector2d d((px.x() - camera.cx_px) / camera.fx_px, (px.y() - camera.cy_px) / camera.fy_px);
  if (camera.lens != hal::LensModel::kEquidistant || d.norm() < 1e-9) {
    return d;
  }
  constexpr double kMaxAngle_rad = 1.4;  // 80 degrees: beyond, x/z grows without bounds.
  if (d.norm() > kMaxAngle_rad) {
    return std::nullopt;
  }
  return d * (std::tan(d.norm()) / d.norm());
}

}  // namespace

std::optional<Eigen::Vector2d> normalised_ray(const hal::CameraModel& camera, const Eigen::Vector2d& px) {
  std::optional<Eigen::Vector2d> ray = undistorted_start(camera, px);
  if (!ray) {
    return std::nullopt;
  }
  const auto project = [&camera](const Eigen::Vector2d& m) { return camera.project({m.x(), m.y(), 1.0}); };
  constexpr int kMaxSteps = 50;
  constexpr double kDone_px = 1e-9;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::Vector2d missing = px - project(*ray);
    if (!missing.allFinite()) {
      return std::nullopt;
    }
    if (missing.norm() < kDone_px) {
      return ray;
    }
    constexpr double kDelta = 1e-6;
    Eigen::Matrix2d J;
    J << (project(*ray + Eigen::Vector2d(kDelta, 0)) - project(*ray - Eigen::Vector2d(kDelta, 0))) / (2 * kDelta),
        (project(*ray + Eigen::Vector2d(0, kDelta)) - project(*ray - Eigen::Vector2d(0, kDelta))) / (2 * kDelta);
    if (std::abs(J.determinant()) < 1e-9) {
      return std::nullopt;
    }
    Eigen::Vector2d move = J.inverse() * missing;
    const double limit = 0.5 * (1.0 + ray->norm());
    if (move.norm() > limit) {
      move *= limit / move.norm();
    }
    *ray += move;
  }
  constexpr double kGoodEnough_px = 1e-4;
  return (px - project(*ray)).norm() < kGoodEnough_px ? ray : std::nullopt;
}

}  // namespace kinetrace::calibration

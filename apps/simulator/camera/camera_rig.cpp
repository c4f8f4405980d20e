#include "camera/camera_rig.hpp"

#include <cmath>

namespace kinetrace::simulator {
namespace {

Eigen::Vector2d distorted(const std::array<double, 5>& d, const Eigen::Vector2d& p) {
  const auto& [k1, k2, p1, p2, k3] = d;
  const double r2 = p.squaredNorm();
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double xy = p.x() * p.y();
  return radial * p + Eigen::Vector2d(2.0 * p1 * xy + p2 * (r2 + 2.0 * p.x() * p.x()),
                                      p1 * (r2 + 2.0 * p.y() * p.y()) + 2.0 * p2 * xy);
}

// Newton's method with a numeric Jacobian: exact for every lens whose distortion can be inverted at all.
Eigen::Vector2d undistorted(const std::array<double, 5>& d, const Eigen::Vector2d& target) {
  constexpr double kStep = 1e-6;
  Eigen::Vector2d p = target;
  for (int i = 0; i < 12; ++i) {
    const Eigen::Vector2d error = distorted(d, p) - target;
    Eigen::Matrix2d jacobian;
    jacobian.col(0) = (distorted(d, p + Eigen::Vector2d(kStep, 0.0)) - distorted(d, p)) / kStep;
    jacobian.col(1) = (distorted(d, p + Eigen::Vector2d(0.0, kStep)) - distorted(d, p)) / kStep;
    const Eigen::Vector2d step = jacobian.fullPivLu().solve(error);
    p -= step;
    if (step.squaredNorm() < 1e-20) {
      break;
    }
  }
  return p;
}

RawCamera pinhole(const StereoGeometry& g) {
  RawCamera camera;
  camera.width_px = g.width_px;
  camera.height_px = g.height_px;
  camera.K << g.fx_px, 0, g.cx_px, 0, g.fy_px, g.cy_px, 0, 0, 1;
  return camera;
}

// In the proportions of a well-known driving rig: 1392 x 512 raw pixels for 1242 x 375 rectified ones.
RawCamera barrel(const StereoGeometry& g, const Eigen::Vector2d& off_centre_px, const std::array<double, 5>& distortion,
                 const Eigen::Vector3d& askew_rad) {
  RawCamera camera;
  camera.width_px = static_cast<int>(std::lround(g.width_px * 1392.0 / 1242.0));
  camera.height_px = static_cast<int>(std::lround(g.height_px * 512.0 / 375.0));
  // Distortion moves the corners of the longer side furthest inwards: the focal length keeps them in the picture.
  const double f = 1.12 * g.fx_px;
  camera.K << f, 0, 0.5 * (camera.width_px - 1) + off_centre_px.x(), 0, 0.997 * f,
      0.5 * (camera.height_px - 1) + off_centre_px.y(), 0, 0, 1;
  camera.distortion = distortion;
  camera.R_rect = so3_exp(askew_rad);
  return camera;
}

// Offsets from a pixel's centre to its samples, then zero for the centre itself.
std::vector<Eigen::Vector2d> sample_offsets(int samples_per_side) {
  const double n = samples_per_side;
  std::vector<Eigen::Vector2d> offsets;
  for (int j = 0; j < samples_per_side; ++j) {
    for (int i = 0; i < samples_per_side; ++i) {
      offsets.emplace_back((i + (n - j - 0.5) / n) / n - 0.5, (j + (i + 0.5) / n) / n - 0.5);
    }
  }
  offsets.emplace_back(0.0, 0.0);
  return offsets;
}

}  // namespace

bool RawCamera::is_pinhole() const {
  return distortion == std::array<double, 5>{} && R_rect.isIdentity(0.0);
}

Eigen::Vector2d RawCamera::rectified_ray(const Eigen::Vector2d& pixel) const {
  Eigen::Vector2d normalised((pixel.x() - K(0, 2)) / K(0, 0), (pixel.y() - K(1, 2)) / K(1, 1));
  if (is_pinhole()) {
    return normalised;
  }
  return (R_rect * undistorted(distortion, normalised).homogeneous()).hnormalized();
}

Eigen::Vector2d RawCamera::project(const Eigen::Vector3d& p_rect) const {
  const Eigen::Vector2d p = distorted(distortion, (R_rect.transpose() * p_rect).hnormalized());
  return {K(0, 0) * p.x() + K(0, 2), K(1, 1) * p.y() + K(1, 2)};
}

StereoGeometry resized(const StereoGeometry& rig, std::optional<int> width_px, std::optional<int> height_px) {
  StereoGeometry result = rig;
  result.width_px = width_px.value_or(rig.width_px);
  const double scale = static_cast<double>(result.width_px) / rig.width_px;
  result.height_px = height_px.value_or(static_cast<int>(std::lround(rig.height_px * scale)));
  result.fx_px *= scale;
  result.fy_px *= scale;
  // Pixel centres lie at integer coordinates, so that the picture's edge is at -0.5.
  result.cx_px = (rig.cx_px + 0.5) * scale - 0.5;
  result.cy_px = (rig.cy_px + 0.5) * scale - 0.5 + 0.5 * (result.height_px - rig.height_px * scale);
  return result;
}

CameraRig ideal_rig(const StereoGeometry& rectified) {
  return {rectified, {pinhole(rectified), pinhole(rectified)}, false};
}

CameraRig distorted_rig(const StereoGeometry& rectified) {
  return {rectified,
          {barrel(rectified, {6.3, -4.1}, {-0.19, 0.052, 0.0011, -0.0006, -0.0062}, {0.004, -0.0085, -0.006}),
           barrel(rectified, {-3.7, 5.2}, {-0.186, 0.05, -0.0007, 0.0009, -0.0058}, {-0.005, 0.0105, 0.007})},
          true};
}

SampleRays::SampleRays(const RawCamera& camera, int samples_per_side)
    : width_(camera.width_px),
      height_(camera.height_px),
      samples_(samples_per_side * samples_per_side),
      pixel_rad_(static_cast<float>(1.0 / camera.K(0, 0))) {
  const std::vector<Eigen::Vector2d> offsets = sample_offsets(samples_per_side);
  const bool pinhole = camera.is_pinhole();
  const auto width = static_cast<std::size_t>(width_);
  x_steps_ = {offsets.size(), pinhole ? 0 : width * offsets.size()};
  y_steps_ = {pinhole ? 0 : offsets.size(), pinhole ? offsets.size() : width * offsets.size()};
  for (int y = 0; y < height_; ++y) {
    const int columns = pinhole && y > 0 ? 1 : width_;
    for (int x = 0; x < columns; ++x) {
      for (const Eigen::Vector2d& offset : offsets) {
        const Eigen::Vector2f ray = camera.rectified_ray(Eigen::Vector2d(x, y) + offset).cast<float>();
        if (!pinhole || y == 0) {
          xs_.push_back(ray.x());
        }
        if (!pinhole || x == 0) {
          ys_.push_back(ray.y());
        }
      }
    }
  }
}

}  // namespace kinetrace::simulator

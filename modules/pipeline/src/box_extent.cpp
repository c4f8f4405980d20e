#include "box_extent.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace kinetrace::pipeline {
namespace {

/// Deviation of a body's outline from its box, relative to the box's largest dimension.
constexpr double kOutlineSigma = 0.05;

/// Variance of a face along its normal: of the centre and half the size.
Eigen::Vector3d face_variance_m2(const Box3Sigma& sigma) {
  return sigma.center_m.cwiseAbs2() + 0.25 * sigma.size_m.cwiseAbs2();
}

/// Covariance of a corner, in the axes of the box: of its faces, the yaw at the arm of each axis, and the outline.
Eigen::Vector3d corner_variance_m2(const Box3& box, const Box3Sigma& sigma) {
  const Eigen::Vector3d half_m = 0.5 * box.size_m;
  const Eigen::Vector3d by_yaw_m = sigma.yaw_rad * Eigen::Vector3d(half_m.z(), 0.0, half_m.x());
  const double outline_m = kOutlineSigma * box.size_m.maxCoeff();
  return (face_variance_m2(sigma) + by_yaw_m.cwiseAbs2()).array() + outline_m * outline_m;
}

/// Homogeneous; from (u_left, v, disparity, 1), px, to the camera frame, m.
Eigen::Matrix4d triangulation(const StereoGeometry& g) {
  const double y_scale = g.fx_px / g.fy_px;
  Eigen::Matrix4d T_cam_stereo;
  T_cam_stereo << g.baseline_m, 0.0, 0.0, -g.baseline_m * g.cx_px,          //
      0.0, g.baseline_m * y_scale, 0.0, -g.baseline_m * y_scale * g.cy_px,  //
      0.0, 0.0, 0.0, g.baseline_m * g.fx_px,                                //
      0.0, 0.0, 1.0, 0.0;
  return T_cam_stereo;
}

class ExtentOfPoints {
 public:
  ExtentOfPoints(const StereoGeometry& geometry, const Eigen::Matrix3d& covariance_cam)
      : geometry_(geometry), covariance_cam_(covariance_cam) {
    extent_.low_px.setConstant(std::numeric_limits<double>::infinity());
    extent_.high_px.setConstant(-std::numeric_limits<double>::infinity());
  }

  void add(const Eigen::Vector3d& p_cam) {
    const Eigen::Vector2d uv_px = geometry_.project(p_cam).head<2>().array() + 0.5;  // from pixel centres to sides
    const Eigen::Vector2d focal_px(geometry_.fx_px, geometry_.fy_px);
    for (const int axis : {0, 1}) {
      Eigen::Vector3d px_per_m = Eigen::Vector3d::Zero();
      px_per_m[axis] = focal_px[axis] / p_cam.z();
      px_per_m.z() = -focal_px[axis] * p_cam[axis] / (p_cam.z() * p_cam.z());
      const double sigma_px = std::sqrt(px_per_m.dot(covariance_cam_ * px_per_m));
      if (uv_px[axis] < extent_.low_px[axis]) {
        extent_.low_px[axis] = uv_px[axis];
        extent_.low_sigma_px[axis] = sigma_px;
      }
      if (uv_px[axis] > extent_.high_px[axis]) {
        extent_.high_px[axis] = uv_px[axis];
        extent_.high_sigma_px[axis] = sigma_px;
      }
    }
  }

  [[nodiscard]] std::optional<tracking::ImageExtent> extent() const {
    return extent_.low_px.allFinite() ? std::optional(extent_) : std::nullopt;
  }

 private:
  const StereoGeometry& geometry_;
  const Eigen::Matrix3d& covariance_cam_;
  tracking::ImageExtent extent_;
};

}  // namespace

std::optional<tracking::ImageExtent> image_extent(const Box3& box, const Box3Sigma& sigma,
                                                  const Eigen::Matrix3d& position_covariance, const Se3& T_world_cam,
                                                  const StereoGeometry& geometry) {
  const Se3 T_cam_world = T_world_cam.inverse();
  std::array<Eigen::Vector3d, 8> corners = box.corners();
  for (Eigen::Vector3d& corner : corners) {
    corner = T_cam_world * corner;
  }
  const Eigen::Matrix3d axes = box.rotation();
  const Eigen::Matrix3d covariance_world =
      position_covariance + axes * corner_variance_m2(box, sigma).asDiagonal() * axes.transpose();
  const Eigen::Matrix3d covariance_cam = T_cam_world.rotation * covariance_world * T_world_cam.rotation;
  ExtentOfPoints extent(geometry, covariance_cam);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d& from = corners[i];
    const bool is_in_front = from.z() > kMinProjectionDepth_m;
    if (is_in_front) {
      extent.add(from);
    }
    for (const std::size_t bit : {1U, 2U, 4U}) {  // the other ends of its edges
      const Eigen::Vector3d& to = corners[i ^ bit];
      if (is_in_front && to.z() <= kMinProjectionDepth_m) {
        extent.add(from + (from.z() - kMinProjectionDepth_m) / (from.z() - to.z()) * (to - from));
      }
    }
  }
  return extent.extent();
}

tracking::PredictedVolume volume_of(const Box3& box, const Box3Sigma& sigma, const Eigen::Matrix3d& position_covariance,
                                    const Se3& T_world_cam, const StereoGeometry& geometry) {
  const Eigen::Matrix3d R_box_world = box.rotation().transpose();
  Eigen::Matrix4d T_box_cam = Eigen::Matrix4d::Identity();
  T_box_cam.topLeftCorner<3, 3>() = R_box_world * T_world_cam.rotation;
  T_box_cam.topRightCorner<3, 1>() = R_box_world * (T_world_cam.translation - box.center_m);
  const Eigen::Vector3d position_variance_m2 = (R_box_world * position_covariance * R_box_world.transpose()).diagonal();
  return {.T_box_stereo = T_box_cam * triangulation(geometry),
          .half_size_m = 0.5 * box.size_m,
          .sigma_m = (position_variance_m2 + face_variance_m2(sigma)).cwiseSqrt()};
}

}  // namespace kinetrace::pipeline

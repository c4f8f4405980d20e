// Cost functions of the bundle adjustment.
#pragma once

#include <Eigen/Core>
#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>

#include "rig_bundle.hpp"

namespace kinetrace::self_calibration {

/// A point in the left camera's frame, times its inverse depth in the host frame.
template <typename T>
void point_in_left(const Se3& T_world_host, const T* pose, const T* point, T* p_left) {
  const Eigen::Matrix<T, 3, 1> ray{point[0], point[1], T(1)};
  const Eigen::Matrix<T, 3, 1> in_world =
      T_world_host.rotation.cast<T>() * ray + T_world_host.translation.cast<T>() * point[2];
  ceres::AngleAxisRotatePoint(pose, in_world.data(), p_left);
  for (int i = 0; i < 3; ++i) {
    p_left[i] += pose[3 + i] * point[2];
  }
}

struct LeftResidual {
  ImageSize size;
  Se3 T_world_host;
  Eigen::Vector2d raw_px;
  double inverse_sigma;

  template <typename T>
  bool operator()(const T* lens, const T* pose, const T* point, T* residual) const {
    T p_left[3];
    T pixel[2];
    point_in_left(T_world_host, pose, point, p_left);
    project(lens, size, p_left, pixel);
    residual[0] = inverse_sigma * (pixel[0] - raw_px.x());
    residual[1] = inverse_sigma * (pixel[1] - raw_px.y());
    return true;
  }
  using Cost = ceres::AutoDiffCostFunction<LeftResidual, 2, kLensSize, 6, 3>;
};

struct RightResidual {
  LeftResidual view;
  double baseline_m;

  template <typename T>
  bool operator()(const T* lens, const T* mount, const T* pose, const T* point, T* residual) const {
    T p_left[3];
    T p_right[3];
    T direction[3];
    T pixel[2];
    point_in_left(view.T_world_host, pose, point, p_left);
    ceres::AngleAxisRotatePoint(mount, p_left, p_right);
    baseline_direction(mount, direction);
    for (int i = 0; i < 3; ++i) {
      p_right[i] += baseline_m * direction[i] * point[2];
    }
    project(lens, view.size, p_right, pixel);
    residual[0] = view.inverse_sigma * (pixel[0] - view.raw_px.x());
    residual[1] = view.inverse_sigma * (pixel[1] - view.raw_px.y());
    return true;
  }
  using Cost = ceres::AutoDiffCostFunction<RightResidual, 2, kLensSize, kMountSize, 6, 3>;
};

/// Weak prior of one lens: zero with its sigma; the focal length about the image's width.
struct LensPrior {
  LensBlock sigma;
  template <typename T>
  bool operator()(const T* lens, T* residual) const {
    for (int i = 0; i < kLensSize; ++i) {
      residual[i] = lens[i] / sigma[static_cast<std::size_t>(i)];
    }
    return true;
  }
  using Cost = ceres::AutoDiffCostFunction<LensPrior, kLensSize, kLensSize>;
};

struct LensDifferencePrior {
  LensBlock sigma;
  template <typename T>
  bool operator()(const T* left, const T* right, T* residual) const {
    for (int i = 0; i < kLensSize; ++i) {
      residual[i] = (right[i] - left[i]) / sigma[static_cast<std::size_t>(i)];
    }
    return true;
  }
  using Cost = ceres::AutoDiffCostFunction<LensDifferencePrior, kLensSize, kLensSize, kLensSize>;
};

struct MountPrior {
  double sigma;
  template <typename T>
  bool operator()(const T* mount, T* residual) const {
    for (int i = 0; i < kMountSize; ++i) {
      residual[i] = mount[i] / sigma;
    }
    return true;
  }
  using Cost = ceres::AutoDiffCostFunction<MountPrior, kMountSize, kMountSize>;
};

}  // namespace kinetrace::self_calibration

#include "uncertainty.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace kinetrace::self_calibration {
namespace {

using RigRow = Eigen::Matrix<double, 1, kRigSize>;

Eigen::Vector2d pixel_in(const RigModel& rig, std::size_t view, const Eigen::Vector3d& p_left) {
  const Eigen::Vector3d p_view = view == 0 ? p_left : rig.T_right_left() * p_left;
  Eigen::Vector2d pixel;
  project(rig.lens[view].data(), rig.size, p_view.data(), pixel.data());
  return pixel;
}

/// Derivative of a point's relative depth by the rig's parameters.
RigRow depth_derivative(const RigModel& rig, const Eigen::Vector3d& p_left) {
  constexpr double kStep = 1e-6;
  const Eigen::Vector2d left_px = pixel_in(rig, 0, p_left);
  const Eigen::Vector2d right_px = pixel_in(rig, 1, p_left);
  RigRow derivative;
  for (int i = 0; i < kRigSize; ++i) {
    RigModel moved = rig;
    moved.parameter(i) += kStep;
    derivative[i] = (1.0 - inverse_depth(moved, left_px, right_px) * p_left.z()) / kStep;
  }
  return derivative;
}

}  // namespace

RigCovariance rig_covariance(const RigModel& rig, const std::vector<BundleWindow>& windows,
                             const BundleOptions& options) {
  RigCovariance normal = prior_information(rig, options.priors).normal;
  RigCovariance scatter = RigCovariance::Zero();
  for (const BundleWindow& window : windows) {
    const RigInformation part = rig_information(rig, window, options);
    normal += part.normal;
    scatter += part.gradient * part.gradient.transpose();
  }
  const RigCovariance formal = normal.ldlt().solve(RigCovariance::Identity());
  const auto count = static_cast<double>(windows.size());
  return formal + count / std::max(count - 1.0, 1.0) * formal * scatter * formal;
}

double focal_sigma(const RigCovariance& covariance) {
  return std::sqrt(
      std::max(covariance(kLogFocal, kLogFocal), covariance(kLensSize + kLogFocal, kLensSize + kLogFocal)));
}

double depth_sigma(const RigModel& rig, const RigCovariance& covariance, double depth_m) {
  constexpr int kSteps = 2;
  double variance = 0.0;
  int count = 0;
  for (int row = -kSteps; row <= kSteps; ++row) {
    for (int column = -kSteps; column <= kSteps; ++column) {
      const Eigen::Vector2d at =
          rig.size.centre_px() + Eigen::Vector2d(column * rig.size.width_px, row * rig.size.height_px) / (3.0 * kSteps);
      const Eigen::Vector3d ray = unproject(rig.lens[0], rig.size, at).homogeneous();
      const RigRow derivative = depth_derivative(rig, depth_m * ray);
      variance += derivative * covariance * derivative.transpose();
      ++count;
    }
  }
  return std::sqrt(variance / count);
}

}  // namespace kinetrace::self_calibration

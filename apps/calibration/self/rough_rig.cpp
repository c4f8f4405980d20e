#include "rough_rig.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <ceres/ceres.h>
#include <ceres/normal_prior.h>
#include <ceres/rotation.h>

namespace kinetrace::self_calibration {
namespace {

/// Undistorted ray from a distorted one: the division model of Fitzgibbon (CVPR 2001) to first order, which needs no
/// inversion.
template <typename T>
Eigen::Matrix<T, 3, 1> straightened(const Eigen::Vector2d& ray, const T& bend) {
  const T scale = T(1) + bend * ray.squaredNorm();
  return {scale * ray.x(), scale * ray.y(), T(1)};
}

/// Signed distance of a pair from its epipolar geometry, in pixels.
struct SampsonDistance {
  Eigen::Vector2d left;  ///< Distorted rays: (pixel - centre) / focal length.
  Eigen::Vector2d right;
  double focal_px;

  template <typename T>
  bool operator()(const T* mount, const T* bend, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Vector x = straightened(left, bend[0]);
    const Vector x_right = straightened(right, bend[0]);
    Vector t;
    baseline_direction(mount, t.data());
    Vector turned;
    ceres::AngleAxisRotatePoint(mount, x.data(), turned.data());
    const Vector line_right = t.cross(turned);
    const Vector back = x_right.cross(t);
    const Vector inverse{-mount[0], -mount[1], -mount[2]};
    Vector line_left;
    ceres::AngleAxisRotatePoint(inverse.data(), back.data(), line_left.data());
    using std::sqrt;
    const T gradient2 = line_right.template head<2>().squaredNorm() + line_left.template head<2>().squaredNorm();
    residual[0] = focal_px * x_right.dot(line_right) / sqrt(gradient2 + T(1e-12));
    return true;
  }
};

class EpipolarFit {
 public:
  EpipolarFit(std::span<const PointPair> pairs, const ImageSize& size, double focal_px) {
    for (const PointPair& pair : pairs) {
      distances_.push_back(
          {(pair.left_px - size.centre_px()) / focal_px, (pair.right_px - size.centre_px()) / focal_px, focal_px});
    }
  }

  void minimise(double scale_px) {
    ceres::Problem problem;
    for (const SampsonDistance& distance : distances_) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<SampsonDistance, 1, kMountSize, 1>(new SampsonDistance(distance)),
          new ceres::CauchyLoss(scale_px), mount.data(), &bend);
    }
    problem.AddResidualBlock(prior(), nullptr, mount.data());
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = 40;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    cost = summary.final_cost;
  }

  [[nodiscard]] double distance_px(std::size_t i) const {
    double residual = 0.0;
    distances_[i](mount.data(), &bend, &residual);
    return std::abs(residual);
  }

  MountBlock mount{};
  double bend = 0.0;
  double cost = std::numeric_limits<double>::infinity();

 private:
  /// Prior of parallel views; constrains parameters that few pairs leave undetermined.
  static ceres::CostFunction* prior() {
    constexpr double kInverseSigma = 1.0 / 0.05;
    ceres::Matrix weight = ceres::Matrix::Identity(kMountSize, kMountSize) * kInverseSigma;
    return new ceres::NormalPrior(weight, ceres::Vector::Zero(kMountSize));
  }

  std::vector<SampsonDistance> distances_;
};

EpipolarFit best_fit(std::span<const PointPair> pairs, const ImageSize& size, double focal_px) {
  constexpr std::array<double, 3> kStartBends{0.0, 0.2, 0.4};
  constexpr std::array<double, 4> kScales_px{20.0, 6.0, 2.0, 1.0};
  EpipolarFit best(pairs, size, focal_px);
  for (const double start : kStartBends) {
    EpipolarFit fit(pairs, size, focal_px);
    fit.bend = start;
    for (const double scale : kScales_px) {
      fit.minimise(scale);
    }
    if (fit.cost < best.cost) {
      best = fit;
    }
  }
  return best;
}

}  // namespace

RoughRig rough_rig(std::span<const PointPair> pairs, const ImageSize& size, double baseline_m, double focal_px) {
  constexpr double kInlier_px = 4.0;
  const EpipolarFit fit = best_fit(pairs, size, focal_px);
  RoughRig rough{plain_rig(size, baseline_m, focal_px), {}, 0.0};
  rough.rig.mount = fit.mount;
  // Both distortion models agree near the centre and, by k2, at the corners.
  const double corner = 0.5 * std::hypot(size.width_px, size.height_px) / focal_px;
  const double straight = corner * (1.0 + fit.bend * corner * corner);
  const double k2 = (corner / straight - 1.0 + fit.bend * straight * straight) / std::pow(straight, 4);
  for (LensBlock& lens : rough.rig.lens) {
    lens[kK1] = -fit.bend;
    lens[kK2] = k2;
  }
  double sum2 = 0.0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double distance = fit.distance_px(i);
    if (distance < kInlier_px) {
      rough.inliers.push_back(pairs[i]);
      sum2 += distance * distance;
    }
  }
  rough.rms_px = std::sqrt(sum2 / static_cast<double>(std::max<std::size_t>(rough.inliers.size(), 1)));
  return rough;
}

}  // namespace kinetrace::self_calibration

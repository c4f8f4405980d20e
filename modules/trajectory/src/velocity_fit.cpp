#include "velocity_fit.hpp"

#include <algorithm>

#include <Eigen/Cholesky>

#include "kinetrace/core/quantiles.hpp"

namespace kinetrace::trajectory {
namespace {

constexpr double kAccelerationPrior_mps2 = 20.0;
// Weight of the given covariance against the residuals' chi-square, in rows.
constexpr double kPriorDegreesOfFreedom = 3.0;

template <int kOrder>
struct Polynomial {
  Eigen::Matrix<double, 3 * (kOrder + 1), 1> coefficients;  // Position, velocity, half the acceleration.
  Eigen::Matrix3d velocity_covariance;
  double chi_square = 0.0;
  double variance_factor = 1.0;
};

/// Positions are relative to the first point, for conditioning: the offset has no prior.
template <int kOrder>
Polynomial<kOrder> fit(std::span<const PathPoint> points, const Eigen::Matrix3d& prior_information) {
  constexpr int kSize = 3 * (kOrder + 1);
  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  Matrix information = Matrix::Zero();
  Vector rhs = Vector::Zero();
  information.template block<3, 3>(3, 3) = prior_information;
  if constexpr (kOrder == 2) {
    // The coefficient is half the acceleration.
    information.diagonal().template segment<3>(6).setConstant(4.0 /
                                                              (kAccelerationPrior_mps2 * kAccelerationPrior_mps2));
  }
  const Eigen::Vector3d origin = points.front().position_m;
  for (const PathPoint& point : points) {
    const Eigen::Vector3d weighted = point.information * (point.position_m - origin);
    double row_power = 1.0;
    for (int r = 0; r <= kOrder; ++r, row_power *= point.time_s) {
      rhs.template segment<3>(3 * r) += row_power * weighted;
      double power = row_power;
      for (int c = 0; c <= kOrder; ++c, power *= point.time_s) {
        information.template block<3, 3>(3 * r, 3 * c) += power * point.information;
      }
    }
  }
  const Eigen::LDLT<Matrix> solver(information);
  Polynomial<kOrder> out;
  out.coefficients = solver.solve(rhs);
  const Matrix covariance = solver.solve(Matrix::Identity());
  for (const PathPoint& point : points) {
    Eigen::Vector3d residual = origin - point.position_m;
    double power = 1.0;
    for (int r = 0; r <= kOrder; ++r, power *= point.time_s) {
      residual += power * out.coefficients.template segment<3>(3 * r);
    }
    out.chi_square += residual.dot(point.information * residual);
  }
  const double degrees_of_freedom = std::max(3.0 * static_cast<double>(points.size()) - kSize, 0.0);
  out.variance_factor =
      std::max(1.0, (kPriorDegreesOfFreedom + out.chi_square) / (kPriorDegreesOfFreedom + degrees_of_freedom));
  out.velocity_covariance = out.variance_factor * covariance.template block<3, 3>(3, 3);
  return out;
}

}  // namespace

VelocityFit fit_velocity(std::span<const PathPoint> points, const Eigen::Matrix3d& prior_information) {
  const Polynomial<1> line = fit<1>(points, prior_information);
  if (points.size() >= kMinAcceleratedPoints) {
    const Polynomial<2> curve = fit<2>(points, prior_information);
    if (line.chi_square - curve.chi_square > kChiSquareGate3 * curve.variance_factor) {
      return {curve.coefficients.segment<3>(3), curve.velocity_covariance};
    }
  }
  return {line.coefficients.segment<3>(3), line.velocity_covariance};
}

}  // namespace kinetrace::trajectory

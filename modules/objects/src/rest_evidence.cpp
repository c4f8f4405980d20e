#include "kinetrace/objects/rest_evidence.hpp"

#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "kinetrace/core/body_velocity.hpp"

namespace kinetrace::objects {
namespace {

/// Standard deviations of the speed along each axis, m/s: a slow walk, a fast one, a vehicle in town, on a road.
constexpr std::array<double, 4> kSpeedSigmas_mps{0.3, 1.0, 3.0, 10.0};

/// Log of the normal density, up to a constant.
double log_density(const Eigen::Vector3d& value, const Eigen::Matrix3d& covariance, double sigma) {
  const Eigen::LDLT<Eigen::Matrix3d> solver(covariance + sigma * sigma * Eigen::Matrix3d::Identity());
  return -0.5 * (value.dot(solver.solve(value)) + solver.vectorD().array().log().sum());
}

}  // namespace

double moving_evidence(const Eigen::Vector3d& velocity_mps, const Eigen::Matrix3d& covariance) noexcept {
  const double at_rest = log_density(velocity_mps, covariance, kRestSpeedSigma_mps);
  double ratio = 0.0;
  for (const double speed_mps : kSpeedSigmas_mps) {
    ratio += std::exp(log_density(velocity_mps, covariance, speed_mps) - at_rest) / kSpeedSigmas_mps.size();
  }
  return std::log(ratio);
}

}  // namespace kinetrace::objects

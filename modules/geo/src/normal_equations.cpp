#include "normal_equations.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "kinetrace/core/quantiles.hpp"

namespace kinetrace::geo {
namespace {

using TransposedJacobian = Eigen::Matrix<double, kUnknowns, 3>;

// Medians and 99.9 % quantiles of chi-square with one and two degrees of freedom.
constexpr double kMedian1 = 0.4549;
constexpr double kMedian2 = 1.3863;
constexpr double kGate1 = 10.828;
constexpr double kGate2 = 13.816;
// Lower bound for paths and receivers; keeps perfect data from dividing by zero.
constexpr double kMinNoise_m = 0.01;

double horizontal_square(const Residual& residual, const Match& match) {
  return residual.error_m.head<2>().cwiseQuotient(match.sigma_m.head<2>()).squaredNorm();
}

double vertical_square(const Residual& residual, const Match& match) {
  return std::pow(residual.error_m.z() / match.sigma_m.z(), 2);
}

}  // namespace

std::vector<Residual> linearise(std::span<const Match> matches, const Se3& T_map_world,
                                const Eigen::Vector3d& center_m) {
  std::vector<Residual> residuals;
  for (const Match& match : matches) {
    const Eigen::Vector3d mapped = T_map_world * match.point.world_m;
    Residual residual;
    residual.error_m = match.enu_m - mapped;
    residual.jacobian.leftCols<3>() = -skew(mapped - center_m);
    residual.jacobian.middleCols<3>(3).setIdentity();
    residual.jacobian.col(kOffsetUnknown) = T_map_world.rotation * match.point.velocity_mps;
    residual.jacobian.col(kScaleUnknown) = mapped - center_m;
    residual.distance_m = match.point.distance_m;
    residual.fix = match.fix;
    residuals.push_back(residual);
  }
  return residuals;
}

NoiseScale weigh(std::span<const Match> matches, std::vector<Residual>& residuals) {
  std::vector<double> horizontal;
  std::vector<double> vertical;
  std::vector<double> sigmas_m;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    horizontal.push_back(horizontal_square(residuals[i], matches[i]));
    vertical.push_back(vertical_square(residuals[i], matches[i]));
    sigmas_m.push_back(matches[i].sigma_m.minCoeff());
  }
  const double least = kMinNoise_m / median(sigmas_m);
  const NoiseScale scale{std::max(std::sqrt(median(std::vector(horizontal)) / kMedian2), least),
                         std::max(std::sqrt(median(std::vector(vertical)) / kMedian1), least)};
  const Eigen::Vector3d factors(scale.horizontal, scale.horizontal, scale.vertical);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const bool is_inlier = horizontal[i] <= kGate2 * scale.horizontal * scale.horizontal &&
                           vertical[i] <= kGate1 * scale.vertical * scale.vertical;
    residuals[i].weight.setZero();
    if (is_inlier) {
      residuals[i].weight = matches[i].sigma_m.cwiseProduct(factors).cwiseAbs2().cwiseInverse();
    }
  }
  return scale;
}

std::vector<int> free_unknowns(const AlignmentConfig& config, bool with_scale) {
  std::vector<int> unknowns{2, 3, 4, 5};
  if (config.freedom == Freedom::kRotation) {
    unknowns = {0, 1, 2, 3, 4, 5};
  }
  if (config.max_time_offset_s > 0.0) {
    unknowns.push_back(kOffsetUnknown);
  }
  if (with_scale) {
    unknowns.push_back(kScaleUnknown);
  }
  return unknowns;
}

UnknownMatrix information(std::span<const Residual> residuals, const AlignmentConfig& config) {
  constexpr double kAnyPlace_m = 1e5;
  constexpr double kAnyScale = 10.0;
  const double any_offset_s = std::max(config.max_time_offset_s, 1e-3);
  UnknownVector prior;
  prior << Eigen::Vector3d::Constant(M_PI), Eigen::Vector3d::Constant(kAnyPlace_m), any_offset_s, kAnyScale;
  UnknownMatrix sum = prior.cwiseAbs2().cwiseInverse().asDiagonal();
  for (const Residual& residual : residuals) {
    sum += residual.jacobian.transpose() * residual.weight.asDiagonal() * residual.jacobian;
  }
  return sum;
}

UnknownVector gradient(std::span<const Residual> residuals) {
  UnknownVector sum = UnknownVector::Zero();
  for (const Residual& residual : residuals) {
    sum += residual.jacobian.transpose() * residual.weight.cwiseProduct(residual.error_m);
  }
  return sum;
}

double correlation_time(std::span<const Residual> residuals) {
  std::vector<Eigen::Vector3d> errors;
  for (const Residual& residual : residuals) {
    if (residual.is_inlier()) {
      errors.emplace_back(residual.error_m.cwiseProduct(residual.weight.cwiseSqrt()));
    }
  }
  double power = 0.0;
  for (const Eigen::Vector3d& error : errors) {
    power += error.squaredNorm();
  }
  const auto correlation = [&](std::size_t lag) {
    double sum = 0.0;
    for (std::size_t i = lag; i < errors.size(); ++i) {
      sum += errors[i].dot(errors[i - lag]);
    }
    return power > 0.0 ? sum / power : 0.0;
  };
  double time = -1.0;
  // Sums of two neighbouring lags are positive for any reversible process; the first negative sum is noise.
  for (std::size_t lag = 0; lag + 1 < errors.size(); lag += 2) {
    const double pair = correlation(lag) + correlation(lag + 1);
    if (pair <= 0.0) {
      break;
    }
    time += 2.0 * pair;
  }
  return std::max(time, 1.0);
}

UnknownMatrix covariance(std::span<const Residual> residuals, const UnknownMatrix& information,
                         const std::vector<int>& unknowns, double correlation, double drift_m, double path_m) {
  // Two points of a random walk share the steps before the first of them: the sum over pairs is a sum over the steps.
  TransposedJacobian ahead = TransposedJacobian::Zero();
  UnknownMatrix walked = UnknownMatrix::Zero();
  for (std::size_t i = residuals.size(); i-- > 0;) {
    ahead += residuals[i].jacobian.transpose() * residuals[i].weight.asDiagonal();
    const double step_m = residuals[i].distance_m - (i > 0 ? residuals[i - 1].distance_m : 0.0);
    walked += step_m * ahead * ahead.transpose();
  }
  const double variance_per_m = drift_m * drift_m / std::max(path_m, 1e-6);
  const UnknownMatrix middle = correlation * information + variance_per_m * walked;
  const Eigen::MatrixXd small = information(unknowns, unknowns);
  const Eigen::MatrixXd inverse = small.ldlt().solve(Eigen::MatrixXd::Identity(small.rows(), small.cols()));
  UnknownMatrix whole = UnknownMatrix::Zero();
  whole(unknowns, unknowns) = inverse * middle(unknowns, unknowns) * inverse;
  return whole;
}

}  // namespace kinetrace::geo

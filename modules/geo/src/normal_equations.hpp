// The linearised problem of an alignment.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "alignment_model.hpp"

namespace kinetrace::geo {

/// Unknowns: rotation about the map's axes through the path's middle, position, time offset, and scale, which is only
/// estimated as a check.
inline constexpr int kOffsetUnknown = 6;
inline constexpr int kScaleUnknown = 7;
inline constexpr int kUnknowns = 8;
using UnknownVector = Eigen::Matrix<double, kUnknowns, 1>;
using UnknownMatrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Jacobian = Eigen::Matrix<double, 3, kUnknowns>;

/// Factor from the reference's stated sigmas to its noise.
struct NoiseScale {
  double horizontal = 1.0;
  double vertical = 1.0;
};

/// Residual of a match under a transform.
struct Residual {
  Eigen::Vector3d error_m = Eigen::Vector3d::Zero();  ///< Fix minus point, on the map.
  Jacobian jacobian = Jacobian::Zero();               ///< Of the point.
  Eigen::Vector3d weight = Eigen::Vector3d::Zero();   ///< Inverse variances; 0 for an outlier.
  double distance_m = 0.0;                            ///< Along the path.
  std::size_t fix = 0;

  [[nodiscard]] bool is_inlier() const noexcept { return weight.x() > 0.0; }
};

[[nodiscard]] std::vector<Residual> linearise(std::span<const Match> matches, const Se3& T_map_world,
                                              const Eigen::Vector3d& center_m);

/// Noise from the residuals' medians, which are robust to outliers; then the weights, with chi-square gates.
[[nodiscard]] NoiseScale weigh(std::span<const Match> matches, std::vector<Residual>& residuals);

/// Indices of the estimated unknowns, in order.
[[nodiscard]] std::vector<int> free_unknowns(const AlignmentConfig& config, bool with_scale);

/// J^T W J with a very wide prior, so that it is always invertible.
[[nodiscard]] UnknownMatrix information(std::span<const Residual> residuals, const AlignmentConfig& config);
[[nodiscard]] UnknownVector gradient(std::span<const Residual> residuals);

/// Autocorrelation time of the inliers' weighted errors, the number of neighbours that count as one, by the initial
/// positive sequence (Geyer, Stat. Sci. 1992, sec. 3.3); at least 1.
[[nodiscard]] double correlation_time(std::span<const Residual> residuals);

/// Covariance of `unknowns`, zero elsewhere: white noise times `correlation`, and a random walk of the path that
/// reaches `drift_m` at its end, after `path_m`.
[[nodiscard]] UnknownMatrix covariance(std::span<const Residual> residuals, const UnknownMatrix& information,
                                       const std::vector<int>& unknowns, double correlation, double drift_m,
                                       double path_m);

}  // namespace kinetrace::geo

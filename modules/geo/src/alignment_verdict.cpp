#include "alignment_verdict.hpp"

#include <cmath>
#include <cstdio>

#include <Eigen/Eigenvalues>

#include "alignment_search.hpp"
#include "utc_time.hpp"

namespace kinetrace::geo {
namespace {

constexpr double kDegrees = 180.0 / M_PI;

std::string number(double value, const char* format = "%.3g") {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// Direction of the path's largest extent, on the map.
Eigen::Vector3d main_direction(std::span<const Residual> residuals) {
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Residual& residual : residuals) {
    const Eigen::Vector3d from_center = residual.jacobian.col(kScaleUnknown);
    spread += from_center * from_center.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(2);
}

std::string unknown_rotation(const Alignment& alignment, std::span<const Residual> residuals,
                             const AlignmentConfig& config, const Eigen::Vector3d& axis, double sigma_rad) {
  const std::string known = "is known to " + number(sigma_rad * kDegrees) + " degrees only (at most " +
                            number(config.max_rotation_sigma_rad * kDegrees) + ")";
  const std::string noise = "for a reference with " +
                            number(std::max(alignment.horizontal_noise_m, alignment.vertical_noise_m)) +
                            " m of noise and a path with " + number(100.0 * config.path_drift) + " % of drift";
  if (config.freedom == Freedom::kYaw) {
    return "the heading " + known + ": the path of " + number(alignment.path_m) +
           " m extends too little in the plane " + noise + "; record a longer one";
  }
  // Closer to the line's direction than to any other axis.
  constexpr double kAlong = 0.7;
  if (std::abs(axis.dot(main_direction(residuals))) > kAlong) {
    return "the rotation about the direction of travel " + known + ": the path is a straight line " + noise +
           "; record one that turns, or, if the camera was level at its first frame, align heading and position alone "
           "(--dof 4)";
  }
  return "the rotation " + known + ": the path of " + number(alignment.path_m) + " m is too short " + noise +
         "; record a longer one";
}

}  // namespace

std::string too_few_fixes(const AntennaPath& path, std::span<const Fix> fixes, const AlignmentConfig& config) {
  if (fixes.empty()) {
    return "the reference has no fix";
  }
  const double begin_s = static_cast<double>(path.begin_ns() - fixes.front().time_ns) * 1e-9;
  return "fewer than " + std::to_string(kMinFixes) + " fixes fall into the camera's path within " +
         number(config.max_time_offset_s) + " s of a time offset of " + number(config.time_offset_s, "%.9g") +
         " s: the path lasts from " + date_time_text(path.begin_ns()) + " to " + date_time_text(path.end_ns()) +
         ", the reference from " + date_time_text(fixes.front().time_ns) + " to " +
         date_time_text(fixes.back().time_ns) + "; both begin together with --time-offset " + number(begin_s, "%.3f");
}

std::string what_is_missing(const Alignment& alignment, std::span<const Residual> residuals,
                            const AlignmentConfig& config) {
  if (2 * alignment.inliers < alignment.fixes) {
    return "only " + std::to_string(alignment.inliers) + " of " + std::to_string(alignment.fixes) +
           " fixes agree with the path: the reference is of another recording, or the time offset is farther off "
           "than " +
           "what is searched (--max-time-offset)";
  }
  const double searched_s = std::abs(alignment.time_offset_s - config.time_offset_s);
  if (config.max_time_offset_s > 0.0 && searched_s >= config.max_time_offset_s) {
    return "the time offset lies at the end of what is searched, " + number(alignment.time_offset_s, "%.9g") +
           " s; search farther (--max-time-offset)";
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> rotation(alignment.covariance.topLeftCorner<3, 3>());
  const double rotation_sigma_rad = std::sqrt(std::max(rotation.eigenvalues()[2], 0.0));
  if (!(rotation_sigma_rad <= config.max_rotation_sigma_rad)) {
    return unknown_rotation(alignment, residuals, config, rotation.eigenvectors().col(2), rotation_sigma_rad);
  }
  // A metre, as for the rotation; but never stricter than the noise of a single independent fix.
  constexpr double kMaxPositionSigma_m = 1.0;
  const double noise_m = std::max(alignment.horizontal_noise_m, alignment.vertical_noise_m);
  const double limit_m = std::max(kMaxPositionSigma_m, noise_m * std::sqrt(alignment.correlation));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> position(alignment.covariance.bottomRightCorner<3, 3>());
  const double position_sigma_m = std::sqrt(std::max(position.eigenvalues()[2], 0.0));
  if (!(position_sigma_m <= limit_m)) {
    return "the place along the path is known to " + number(position_sigma_m) + " m only (at most " + number(limit_m) +
           "): at a constant speed it is as good with another time offset (sigma " +
           number(alignment.time_offset_sigma_s) +
           " s); give the offset (--time-offset S --max-time-offset 0), or record a path that turns or stops";
  }
  return {};
}

}  // namespace kinetrace::geo

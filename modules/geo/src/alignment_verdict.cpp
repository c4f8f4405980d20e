#include "alignment_verdict.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

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

/// Closer to the path's direction than to any other axis.
bool is_along(const Eigen::Vector3d& axis, std::span<const Residual> residuals) {
  constexpr double kAlong = 0.7;
  return std::abs(axis.dot(main_direction(residuals))) > kAlong;
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
  if (is_along(axis, residuals)) {
    return "the rotation about the direction of travel " + known + ": the path is a straight line " + noise +
           "; record one that turns, or, if the camera was level at its first frame, align heading and position alone "
           "(--dof 4)";
  }
  return "the rotation " + known + ": the path of " + number(alignment.path_m) + " m is too short " + noise +
         "; record a longer one";
}

/// The unit in which the reference's times would be those of the path; empty: none but nanoseconds.
std::string likely_unit(const AntennaPath& path, std::span<const Fix> fixes) {
  constexpr double kYear_ns = 366.0 * static_cast<double>(kDay_ns);
  for (const auto& [unit, nanoseconds] : {std::pair("microseconds", 1e3), {"milliseconds", 1e6}, {"seconds", 1e9}}) {
    const double begin_ns = nanoseconds * static_cast<double>(fixes.front().time_ns);
    if (begin_ns > kYear_ns && std::abs(begin_ns - static_cast<double>(path.begin_ns())) < kYear_ns) {
      return unit;
    }
  }
  return {};
}

/// For a reference and a path that do not overlap, or too shortly.
std::string overlap_remedy(const AntennaPath& path, std::span<const Fix> fixes, const AlignmentConfig& config) {
  if (const std::string unit = likely_unit(path, fixes); !unit.empty()) {
    return "the reference's times are in " + unit + "; give them in nanoseconds";
  }
  const std::int64_t offset_ns = std::llround(1e9 * config.time_offset_s);
  if (fixes.front().time_ns <= path.end_ns() - offset_ns && fixes.back().time_ns >= path.begin_ns() - offset_ns) {
    return "record a longer path, or take a reference with more fixes a second";
  }
  const double begin_s = static_cast<double>(path.begin_ns() - fixes.front().time_ns) * 1e-9;
  return "both begin together with --time-offset " + number(begin_s, "%.3f");
}

}  // namespace

std::string too_few_fixes(const AntennaPath& path, std::span<const Fix> fixes, const AlignmentConfig& config) {
  if (fixes.empty()) {
    return "the reference has no fix";
  }
  return "fewer than " + std::to_string(kMinFixes) + " fixes fall into the camera's path within " +
         number(config.max_time_offset_s) + " s of a time offset of " + number(config.time_offset_s, "%.9g") +
         " s: the path lasts from " + date_time_text(path.begin_ns()) + " to " + date_time_text(path.end_ns()) +
         ", the reference from " + date_time_text(fixes.front().time_ns) + " to " +
         date_time_text(fixes.back().time_ns) + "; " + overlap_remedy(path, fixes, config);
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
  const bool is_roll = is_along(rotation.eigenvectors().col(2), residuals);
  const Eigen::Index axis = is_roll && !config.roll_matters && config.freedom == Freedom::kRotation ? 1 : 2;
  const double rotation_sigma_rad = std::sqrt(std::max(rotation.eigenvalues()[axis], 0.0));
  if (!(rotation_sigma_rad <= config.max_rotation_sigma_rad)) {
    return unknown_rotation(alignment, residuals, config, rotation.eigenvectors().col(axis), rotation_sigma_rad);
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

#include "camera/rig_report.hpp"

#include <cmath>
#include <numbers>

#include "cli/formatted.hpp"

namespace kinetrace::app {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

std::string turn_text(const RigEstimate& rig) {
  const RigCorrection::Vector value = kDegrees * rig.correction.vector();
  const RigCorrection::Vector sigma = kDegrees * rig.sigma_rad;
  return formatted("pitch %.3f +-%.3f, yaw %.3f +-%.3f, roll %.3f +-%.3f degrees", value[0], sigma[0], value[1],
                   sigma[1], value[2], sigma[2]);
}

std::string depth_text(const RigEstimate& rig, const StereoGeometry& geometry) {
  std::string errors;
  for (const double depth_m : kReportedDepths_m) {
    const double error_m = depth_error_m(geometry, rig.correction, depth_m);
    errors += errors.empty() ? "" : ", ";
    errors += std::isfinite(error_m) ? formatted("%+.2f m at %.0f m", error_m, depth_m)
                                     : formatted("no end at %.0f m", depth_m);
  }
  return "depths uncorrected: " + errors;
}

std::string disparity_text(const RigEstimate& rig, const StereoGeometry& geometry) {
  return formatted("common error of disparities %+.2f +-%.2f px", rig.correction.disparity_error_rad() * geometry.fx_px,
                   rig.disparity_sigma_rad * geometry.fx_px);
}

std::string focal_text(const RigEstimate& rig) {
  if (!rig.is_focal_known()) {
    return "focal lengths cannot be judged: the camera has not turned enough";
  }
  return formatted("focal lengths %+.2f +-%.2f %%", 100.0 * rig.correction.focal,
                   100.0 * rig.sigma_rad[RigCorrection::kFocal]);
}

}  // namespace

std::string rig_text(const RigEstimate& rig, const StereoGeometry& geometry) {
  switch (rig.verdict) {
    case RigVerdict::kUnknown:
      return "cannot be judged from this motion: the camera has to move sideways or forward past things that are near";
    case RigVerdict::kHolds: return "holds: " + disparity_text(rig, geometry) + "; " + focal_text(rig);
    case RigVerdict::kOff:
    case RigVerdict::kCorrected: break;
  }
  const std::string knocks = rig.knocks == 0 ? "" : "; changed suddenly " + std::to_string(rig.knocks) + " times";
  return (rig.verdict == RigVerdict::kCorrected ? "off, and corrected: the right camera is turned by "
                                                : "off: the right camera is turned by ") +
         turn_text(rig) + "; " + disparity_text(rig, geometry) + "; " + focal_text(rig) + "; " +
         depth_text(rig, geometry) + knocks;
}

}  // namespace kinetrace::app

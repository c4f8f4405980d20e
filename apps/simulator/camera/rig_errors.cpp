#include "camera/rig_errors.hpp"

#include <cmath>
#include <numbers>

#include "kinetrace/core/se3.hpp"
#include "util/random.hpp"

namespace kinetrace::simulator {
namespace {

// Direction and principal point, each with its own oscillation.
Eigen::Matrix<double, 5, 1> drifted(double amplitude_rad, double time_s, std::uint32_t seed) {
  constexpr double kPeriod_s = 9.0;
  Random random(seed, 31);
  Eigen::Matrix<double, 5, 1> drift;
  for (double& value : drift) {
    value = amplitude_rad *
            std::sin(2.0 * std::numbers::pi * (time_s / kPeriod_s * random.uniform(0.7, 1.3) + random.unit()));
  }
  return drift;
}

}  // namespace

RigErrors::RightCamera RigErrors::right_camera(double time_s, std::uint32_t seed) const {
  RightCamera right;
  if (time_s >= knock_s) {
    right.turn_rad = turn_rad;
    right.baseline_rad = baseline_rad;
  }
  if (drift_mrad > 0.0) {
    const Eigen::Matrix<double, 5, 1> drift = drifted(1e-3 * drift_mrad, time_s, seed);
    right.turn_rad = so3_log(so3_exp(right.turn_rad) * so3_exp(drift.head<3>()));
    right.principal_shift = 0.5 * drift.tail<2>();
  }
  return right;
}

bool RigErrors::move_right_camera() const {
  return drift_mrad > 0.0 || !turn_rad.isZero(0.0) || !baseline_rad.isZero(0.0);
}

Status RigErrors::validate() const {
  constexpr double kMaxAngle_rad = 0.1;
  constexpr double kMaxFocal = 0.2;
  constexpr double kMaxDrift_mrad = 50.0;
  if (!(turn_rad.cwiseAbs().maxCoeff() <= kMaxAngle_rad && baseline_rad.cwiseAbs().maxCoeff() <= kMaxAngle_rad)) {
    return fail(ErrorCode::kInvalidArgument, "the right camera can be turned and set off by at most 5.7 degrees");
  }
  if (!(std::abs(focal) <= kMaxFocal)) {
    return fail(ErrorCode::kInvalidArgument, "the focal length can be off by at most 20 %");
  }
  if (!(drift_mrad >= 0.0 && drift_mrad <= kMaxDrift_mrad)) {
    return fail(ErrorCode::kInvalidArgument, "drift must be from 0 to 50 milliradians");
  }
  return {};
}

CameraRig miscalibrated(const CameraRig& rig, double focal) {
  CameraRig wrong = rig;
  wrong.rectified.fx_px /= 1.0 + focal;
  wrong.rectified.fy_px /= 1.0 + focal;
  for (RawCamera& camera : wrong.raw) {
    camera.K(0, 0) /= 1.0 + focal;
    camera.K(1, 1) /= 1.0 + focal;
  }
  return wrong;
}

}  // namespace kinetrace::simulator

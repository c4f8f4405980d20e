// Parameters of a stereo rig for estimation: two lenses and their mount, all of magnitude about one.
#pragma once

#include <array>
#include <cmath>

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"
#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::self_calibration {

struct ImageSize {
  int width_px = 0;
  int height_px = 0;
  [[nodiscard]] Eigen::Vector2d centre_px() const { return {0.5 * (width_px - 1), 0.5 * (height_px - 1)}; }
};

/// Indices into a lens block. Lengths in image widths, so that all have comparable magnitude.
enum LensParameter : int {
  kLogFocal,   ///< ln(fx / width).
  kLogAspect,  ///< ln(fy / fx).
  kOffsetX,    ///< (cx - centre) / width.
  kOffsetY,    ///< (cy - centre) / width.
  kK1,
  kK2,
  kP1,
  kP2,
  kK3,
  kLensSize
};
/// Indices into a mount block: rotation vector of R_right_left, then the baseline's direction, T = -b (1, y, z) / |.|.
enum MountParameter : int { kTurnX, kTurnY, kTurnZ, kBaselineY, kBaselineZ, kMountSize };

using LensBlock = std::array<double, kLensSize>;
using MountBlock = std::array<double, kMountSize>;
inline constexpr int kRigSize = 2 * kLensSize + kMountSize;

struct RigModel {
  ImageSize size;
  double baseline_m = 0.0;
  std::array<LensBlock, 2> lens{};  ///< Left, right.
  MountBlock mount{};

  [[nodiscard]] Se3 T_right_left() const;
  [[nodiscard]] double focal_px(std::size_t view) const { return size.width_px * std::exp(lens[view][kLogFocal]); }
  /// Index over left lens, right lens, mount.
  [[nodiscard]] double& parameter(int place);
};

/// A rig of two equal, parallel lenses without distortion.
[[nodiscard]] RigModel plain_rig(const ImageSize& size, double baseline_m, double focal_px);
[[nodiscard]] hal::RigCalibration to_calibration(const RigModel& rig);
/// The reverse, for lenses of the radial-tangential model without rational terms and a pose between them.
[[nodiscard]] RigModel to_model(const hal::RigCalibration& calibration);

/// Brown, "Decentering distortion of lenses", 1966: pixel of a point in the camera's frame, up to scale.
template <typename T>
void project(const T* lens, const ImageSize& size, const T* p_cam, T* pixel) {
  using std::exp;
  const T x = p_cam[0] / p_cam[2];
  const T y = p_cam[1] / p_cam[2];
  const T r2 = x * x + y * y;
  const T radial = T(1) + r2 * (lens[kK1] + r2 * (lens[kK2] + r2 * lens[kK3]));
  const T xd = x * radial + T(2) * lens[kP1] * x * y + lens[kP2] * (r2 + T(2) * x * x);
  const T yd = y * radial + lens[kP1] * (r2 + T(2) * y * y) + T(2) * lens[kP2] * x * y;
  const T width(static_cast<double>(size.width_px));
  const T fx = width * exp(lens[kLogFocal]);
  const Eigen::Vector2d centre = size.centre_px();
  pixel[0] = fx * xd + width * lens[kOffsetX] + T(centre.x());
  pixel[1] = fx * exp(lens[kLogAspect]) * yd + width * lens[kOffsetY] + T(centre.y());
}

/// Unit direction of T_right_left's translation: the right camera's origin in units of the baseline.
template <typename T>
void baseline_direction(const T* mount, T* direction) {
  using std::sqrt;
  const T scale = T(-1) / sqrt(T(1) + mount[kBaselineY] * mount[kBaselineY] + mount[kBaselineZ] * mount[kBaselineZ]);
  direction[0] = scale;
  direction[1] = scale * mount[kBaselineY];
  direction[2] = scale * mount[kBaselineZ];
}

/// The ray (x, y, 1) of a pixel; Newton's method.
[[nodiscard]] Eigen::Vector2d unproject(const LensBlock& lens, const ImageSize& size, const Eigen::Vector2d& pixel);

/// Inverse depth along the left ray of a left-right pair, 1/m, by least squares; negative behind infinity.
[[nodiscard]] double inverse_depth(const RigModel& rig, const Eigen::Vector2d& left_px,
                                   const Eigen::Vector2d& right_px);

}  // namespace kinetrace::self_calibration

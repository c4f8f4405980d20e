// Deviation of a stereo rig from its calibration.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include <Eigen/Core>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace {

/// Deviation of a rectified rig from its calibration; small angles. Projection into the right image: p_right =
/// so3_exp(-turn) * (p_left - c), c = baseline * (1, baseline_rad) normalised, u = f (x / z - shift) + cx, f = fx (1 +
/// focal) in both cameras.
struct KINETRACE_API RigCorrection {
  static constexpr int kSize = 7;
  static constexpr int kShift = 5;  ///< Entry of the vector.
  static constexpr int kFocal = 6;  ///< Entry of the vector, the last.

  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;

  /// Rotation of the right camera, so3_exp(turn), in its own axes: pitch (x), yaw (y), roll (z).
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  /// Direction of the baseline: slope down (y) and forward (z) from the left camera's x axis. Its length is as
  /// calibrated.
  Eigen::Vector2d baseline_rad = Eigen::Vector2d::Zero();
  /// Shift of the right camera's principal point to the left of the calibrated one, in focal lengths. A shift of its
  /// row looks like pitch.
  double shift_rad = 0.0;
  /// Ratio of true to calibrated focal length of both cameras, less one. Pixels are unaffected; depths grow by this
  /// factor.
  double focal = 0.0;

  [[nodiscard]] Vector vector() const { return (Vector() << turn_rad, baseline_rad, shift_rad, focal).finished(); }
  [[nodiscard]] static RigCorrection from(const Vector& v) {
    return {v.head<3>(), v.segment<2>(3), v[kShift], v[kFocal]};
  }
  /// Error common to all disparities, at the image's middle, in focal lengths: measured disparities are too large by
  /// this.
  [[nodiscard]] double disparity_error_rad() const { return turn_rad.y() + shift_rad; }
  [[nodiscard]] bool is_zero() const { return vector().isZero(0.0); }

  /// Maps a pixel of the right image as calibrated to one of the image as captured, for points of any depth;
  /// homogeneous.
  [[nodiscard]] Eigen::Matrix3d raw_from_turned(const StereoGeometry& geometry) const;
  /// Displacement of a point at `right_px`, in an image corrected for the turn, due to the direction of the baseline;
  /// to be subtracted.
  [[nodiscard]] Eigen::Vector2d baseline_shift_px(const StereoGeometry& geometry, const Eigen::Vector2d& right_px,
                                                  double disparity_px) const;
  /// Pixel in the captured image of a point that lies at `right_px` after both corrections.
  [[nodiscard]] Eigen::Vector2d raw_right_px(const StereoGeometry& geometry, const Eigen::Vector2d& right_px,
                                             double disparity_px) const;
};

/// Converts measurements made under one correction to another one.
class KINETRACE_API RigChange {
 public:
  RigChange(const StereoGeometry& geometry, const RigCorrection& before, const RigCorrection& now);
  /// A right pixel with both corrections as before -> with both corrections as now.
  [[nodiscard]] Eigen::Vector2d right_px(const Eigen::Vector2d& before_px, double disparity_px) const;

 private:
  StereoGeometry geometry_;
  RigCorrection before_;
  RigCorrection now_;
  Eigen::Matrix3d now_from_before_;  ///< For pixels corrected for the turn.
};

/// Verdict on a rig's calibration, from the images.
enum class RigVerdict : std::uint8_t {
  kUnknown,    ///< Not observable so far: at rest, turning on the spot, nothing near.
  kHolds,      ///< The images agree with the calibration.
  kOff,        ///< They do not. Also if only the focal lengths are off, which are never corrected while running.
  kCorrected,  ///< They do not, and the estimate is used instead.
};
[[nodiscard]] KINETRACE_API std::string_view to_string(RigVerdict verdict) noexcept;

/// The state of a refinement of the calibration.
struct RigEstimate {
  RigVerdict verdict = RigVerdict::kUnknown;
  RigCorrection correction;  ///< Best estimate.
  RigCorrection::Vector sigma_rad = RigCorrection::Vector::Zero();
  double disparity_sigma_rad = 0.0;  ///< Of disparity_error_rad().
  /// Correction applied to the frame: the certain part of the estimate, without the focal lengths, which would rescale
  /// the world while it is being mapped.
  RigCorrection applied;
  double known_focal = 0.0;   ///< The certain part of correction.focal: for the next start.
  std::uint64_t windows = 0;  ///< Pairs of frames used by the estimate.
  std::uint64_t knocks = 0;   ///< Sudden changes found.

  /// True if focal lengths are known to half a percent. This takes turns of the camera about x or y.
  [[nodiscard]] bool is_focal_known() const noexcept {
    constexpr double kMaxSigma = 0.005;
    return windows > 0 && sigma_rad[RigCorrection::kFocal] < kMaxSigma;
  }
  /// The correction to be saved for the next start.
  [[nodiscard]] RigCorrection lasting() const {
    RigCorrection kept = correction;
    kept.focal = known_focal;
    return kept;
  }
};

/// Depths at which the error of a calibration is reported.
inline constexpr std::array<double, 4> kReportedDepths_m{5.0, 10.0, 20.0, 50.0};
/// Error of a measured depth with yaw and focal lengths uncorrected, in metres; positive: measured too far away.
[[nodiscard]] KINETRACE_API double depth_error_m(const StereoGeometry& geometry, const RigCorrection& correction,
                                                 double depth_m);

}  // namespace kinetrace

// How a stereo rig really stands, where that is not as its calibration says.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include <Eigen/Core>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace {

/// How a rectified rig stands against its calibration; small angles. What points see of it:
/// p_right = so3_exp(-turn) * (p_left - c), c = baseline * (1, baseline_rad) normalised, seen at f (x / z - shift) +
/// cx, f = fx (1 + focal) in both cameras.
struct KINETRACE_API RigCorrection {
  static constexpr int kSize = 7;
  static constexpr int kShift = 5;  ///< Entry of the vector.
  static constexpr int kFocal = 6;  ///< Entry of the vector, the last.

  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;

  /// The right camera is turned by so3_exp(turn), seen from itself: pitch (x), yaw (y), roll (z).
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  /// How far the baseline points down (y) and forward (z) from the left camera's x axis. Its length is as calibrated.
  Eigen::Vector2d baseline_rad = Eigen::Vector2d::Zero();
  /// How far left of the calibrated one the right camera's principal point lies, in focal lengths. Its row looks like
  /// pitch.
  double shift_rad = 0.0;
  /// True focal lengths of both cameras over the calibrated ones, less one. Images are seen as they are; depths are
  /// larger by it.
  double focal = 0.0;

  [[nodiscard]] Vector vector() const { return (Vector() << turn_rad, baseline_rad, shift_rad, focal).finished(); }
  [[nodiscard]] static RigCorrection from(const Vector& v) {
    return {v.head<3>(), v.segment<2>(3), v[kShift], v[kFocal]};
  }
  /// What all disparities have in common, at the image's middle, in focal lengths: they are seen too large by this.
  [[nodiscard]] double disparity_error_rad() const { return turn_rad.y() + shift_rad; }
  [[nodiscard]] bool is_zero() const { return vector().isZero(0.0); }

  /// From a pixel of the right image as the calibration has it to that of the image as the camera gives it, for points
  /// of any depth; homogeneous.
  [[nodiscard]] Eigen::Matrix3d raw_from_turned(const StereoGeometry& geometry) const;
  /// What a point at `right_px`, in an image whose turn is corrected, is shifted by because the baseline points
  /// elsewhere; to be subtracted.
  [[nodiscard]] Eigen::Vector2d baseline_shift_px(const StereoGeometry& geometry, const Eigen::Vector2d& right_px,
                                                  double disparity_px) const;
  /// The pixel of the image as the camera gives it, of a point that lies at `right_px` once corrected for both.
  [[nodiscard]] Eigen::Vector2d raw_right_px(const StereoGeometry& geometry, const Eigen::Vector2d& right_px,
                                             double disparity_px) const;
};

/// Where what was measured under one correction lies under another.
class KINETRACE_API RigChange {
 public:
  RigChange(const StereoGeometry& geometry, const RigCorrection& before, const RigCorrection& now);
  /// A right pixel, corrected for both as it was, corrected as it is now.
  [[nodiscard]] Eigen::Vector2d right_px(const Eigen::Vector2d& before_px, double disparity_px) const;

 private:
  StereoGeometry geometry_;
  RigCorrection before_;
  RigCorrection now_;
  Eigen::Matrix3d now_from_before_;  ///< Of pixels that are corrected for the turn.
};

/// What is known about a rig's calibration from the images.
enum class RigVerdict : std::uint8_t {
  kUnknown,    ///< Motion has not shown enough yet: at rest, turning on the spot, nothing near.
  kHolds,      ///< The images agree with the calibration.
  kOff,        ///< They do not. Also if only the focal lengths are off, which are not corrected while running.
  kCorrected,  ///< They do not, and what they tell is used instead.
};
[[nodiscard]] KINETRACE_API std::string_view to_string(RigVerdict verdict) noexcept;

/// The state of a refinement of the calibration.
struct RigEstimate {
  RigVerdict verdict = RigVerdict::kUnknown;
  RigCorrection correction;  ///< Best estimate.
  RigCorrection::Vector sigma_rad = RigCorrection::Vector::Zero();
  double disparity_sigma_rad = 0.0;  ///< Of disparity_error_rad().
  /// What the frame was corrected by: the part of it that is surely known, but for the focal lengths. Those would
  /// stretch the world while it is being mapped.
  RigCorrection applied;
  double known_focal = 0.0;   ///< The part of correction.focal that is surely known: for the next start.
  std::uint64_t windows = 0;  ///< Pairs of frames that the estimate was made from.
  std::uint64_t knocks = 0;   ///< Sudden changes found.

  /// To half a percent. The camera has to turn for that, not about its axis.
  [[nodiscard]] bool judges_focal() const noexcept {
    constexpr double kJudged = 0.005;
    return windows > 0 && sigma_rad[RigCorrection::kFocal] < kJudged;
  }
  /// What a calibration for the next start is to be corrected by.
  [[nodiscard]] RigCorrection lasting() const {
    RigCorrection kept = correction;
    kept.focal = known_focal;
    return kept;
  }
};

/// Depths at which the error of a calibration is reported.
inline constexpr std::array<double, 4> kReportedDepths_m{5.0, 10.0, 20.0, 50.0};
/// Error of a depth that is measured with yaw and focal lengths uncorrected, in metres, positive: seen too far away.
[[nodiscard]] KINETRACE_API double depth_error_m(const StereoGeometry& geometry, const RigCorrection& correction,
                                                 double depth_m);

}  // namespace kinetrace

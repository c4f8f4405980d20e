// Calibration of a stereo rig: lenses and relative pose of the views.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include <Eigen/Core>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::hal {

enum class LensModel : std::uint8_t {
  kRadialTangential,  ///< k1 k2 p1 p2 [k3 [k4 k5 k6]]: Brown; with k4..k6 the rational model.
  kEquidistant,       ///< k1 k2 k3 k4: fisheye, Kannala and Brandt, "A generic camera model", PAMI 2006.
};

/// One view: pixel centres at integer coordinates, x right, y down.
struct KINETRACE_API CameraModel {
  LensModel lens = LensModel::kRadialTangential;
  int width_px = 0;
  int height_px = 0;
  double fx_px = 0.0;
  double fy_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;
  std::array<double, 8> distortion{};  ///< In the order of LensModel; the rest zero.

  /// Pixel of a point in the camera's frame, z > 0.
  [[nodiscard]] Eigen::Vector2d project(const Eigen::Vector3d& p_cam) const;
};

/// Rectification as a calibration file gives it (KITTI, ROS): x_rect ~ P[:, :3] * R * p_cam.
struct RectifyingTransforms {
  Eigen::Matrix3d R_left = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d R_right = Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 3, 4> P_left = Eigen::Matrix<double, 3, 4>::Zero();
  Eigen::Matrix<double, 3, 4> P_right = Eigen::Matrix<double, 3, 4>::Zero();
  int width_px = 0;  ///< Of the rectified images.
  int height_px = 0;
};

/// A stereo rig in one of three forms:
/// - `rectified` set: the images are rectified already, all else is ignored;
/// - `given` set: raw images of `left` and `right`, rectified by the file's own matrices;
/// - neither: raw images; the rectification is computed from `left`, `right` and `T_right_left`.
struct KINETRACE_API RigCalibration {
  std::string source;  ///< The file or files it was read from, for messages.
  CameraModel left;
  CameraModel right;
  Se3 T_right_left;  ///< p_right = T_right_left * p_left, metres.
  std::optional<RectifyingTransforms> given;
  std::optional<StereoGeometry> rectified;

  /// Size of the images that this calibration is for.
  [[nodiscard]] int raw_width_px() const noexcept { return rectified ? rectified->width_px : left.width_px; }
  [[nodiscard]] int raw_height_px() const noexcept { return rectified ? rectified->height_px : left.height_px; }

  /// Rejects, with kBadCalibration naming the source and the remedy: values that are not finite, focal lengths <= 0,
  /// principal points more than half an image outside, distortion that folds or tears the image halfway to its border,
  /// views of different sizes, invalid rotations, a baseline that is below 1 mm, swapped (right view left of the left
  /// one), not horizontal, or beyond 10 m (millimetres?). Rotations that deviate by rounding are replaced by the
  /// nearest rotation.
  [[nodiscard]] Status validate();
};

/// The calibration of a rig whose views deliver images of this size: an OpenCV stereo calibration (YAML, XML or JSON),
/// a Kalibr camchain, a folder with one of these or a pair of ROS CameraInfo files, KITTI's calib_cam_to_cam.txt
/// (cameras 00 and 01), a ZED factory file (.conf) or a DepthAI EEPROM (JSON). Errors: kNotFound, kBadCalibration
/// (also: for another size).
[[nodiscard]] KINETRACE_API Result<RigCalibration> read_rig_calibration(const std::filesystem::path& path, int width_px,
                                                                        int height_px);

/// Placeholder calibration of images of which only the size is known. Its lenses are arbitrary: for use of the images
/// alone.
[[nodiscard]] KINETRACE_API Result<RigCalibration> images_alone(int width_px, int height_px);

/// How a calibration is written. read_rig_calibration reads both.
enum class CalibrationFormat : std::uint8_t {
  kOpencv,  ///< YAML with K1, D1, K2, D2, R and T; cv::FileStorage reads it.
  kKalibr,  ///< A camchain: cam0 left, cam1 right. Four coefficients per lens.
};

/// Converts any of the three forms to raw images with a relative pose: rectified views become lenses without
/// distortion, rectifying matrices a pose. The rectification is then recomputed from the pose.
[[nodiscard]] KINETRACE_API RigCalibration to_raw_rig(const RigCalibration& rig);

/// The text of a calibration file, with all digits of its numbers. `remarks` become comments at its beginning. Errors:
/// kUnsupported (lenses of two kinds for OpenCV, more than four coefficients for Kalibr), kBadCalibration (see
/// RigCalibration::validate).
[[nodiscard]] KINETRACE_API Result<std::string> rig_calibration_text(const RigCalibration& rig,
                                                                     CalibrationFormat format,
                                                                     std::span<const std::string> remarks = {});

/// Writes that text to `path`, atomically. Errors: as rig_calibration_text; kIo.
[[nodiscard]] KINETRACE_API Status write_rig_calibration(const RigCalibration& rig, const std::filesystem::path& path,
                                                         CalibrationFormat format,
                                                         std::span<const std::string> remarks = {});

/// Checks that write_rig_calibration may write there: the folder can be written, and a file that exists is a
/// calibration in this format. Errors: kIo, kOccupied.
[[nodiscard]] KINETRACE_API Status check_calibration_place(const std::filesystem::path& path, CalibrationFormat format);

/// Geometry of rectified images from their projection matrices P = K [I | t] in a common frame. The baseline is the
/// distance of the centres along x, t = K^-1 P[:, 3]; for cameras with P[2][3] = 0 that is the difference of P[0][3] /
/// fx. Errors: kBadCalibration (see RigCalibration::validate; also different K left and right).
[[nodiscard]] KINETRACE_API Result<StereoGeometry> geometry_from_projections(const Eigen::Matrix<double, 3, 4>& P_left,
                                                                             const Eigen::Matrix<double, 3, 4>& P_right,
                                                                             int width_px, int height_px,
                                                                             const std::string& source);

}  // namespace kinetrace::hal

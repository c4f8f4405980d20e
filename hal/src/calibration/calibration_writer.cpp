// Writes the calibration of a rig in the formats of OpenCV and Kalibr.
#include <algorithm>
#include <array>
#include <charconv>
#include <iterator>
#include <vector>

#include "calibration/calibration_files.hpp"
#include "kinetrace/core/config_check.hpp"
#include "kinetrace/core/files.hpp"
#include "kinetrace/hal/rig_calibration.hpp"
#include "util/messages.hpp"
#include "util/text_file.hpp"

namespace kinetrace::hal {
namespace {

using Numbers = std::vector<double>;

// Smallest number of coefficients, of those that the formats allow, that holds the whole distortion.
std::size_t coefficient_count(const CameraModel& camera) {
  const auto is_zero_from = [&camera](std::size_t first) {
    return std::all_of(camera.distortion.begin() + static_cast<std::ptrdiff_t>(first), camera.distortion.end(),
                       [](double coefficient) { return coefficient == 0.0; });
  };
  if (camera.lens == LensModel::kEquidistant || is_zero_from(4)) {
    return 4;
  }
  return is_zero_from(5) ? 5 : 8;
}

// Round trip: reading yields the same number.
std::string exact(double value) {
  std::array<char, 32> digits{};
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr};
}

std::string bracketed(const Numbers& values) {
  std::string text = "[";
  for (std::size_t i = 0; i < values.size(); ++i) {
    text += (i == 0 ? "" : ", ") + exact(values[i]);
  }
  return text + "]";
}

std::string comments(std::span<const std::string> remarks) {
  std::string text;
  for (const std::string& remark : remarks) {
    std::string line = remark;
    std::replace_if(
        line.begin(), line.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
    text += "# " + line + "\n";
  }
  return text;
}

Numbers distortion(const CameraModel& camera, std::size_t count) {
  return {camera.distortion.begin(), camera.distortion.begin() + static_cast<std::ptrdiff_t>(count)};
}

std::string opencv_matrix(const std::string& key, std::size_t columns, const Numbers& values) {
  return concat(key, ": !!opencv-matrix\n   rows: ", std::to_string(values.size() / columns),
                "\n   cols: ", std::to_string(columns), "\n   dt: d\n   data: ", bracketed(values), "\n");
}

std::string opencv_camera(const std::string& view, const CameraModel& camera, std::size_t coefficients) {
  return opencv_matrix("K" + view, 3, {camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1}) +
         opencv_matrix("D" + view, coefficients, distortion(camera, coefficients));
}

std::string_view opencv_lens(LensModel lens, std::size_t coefficients) {
  if (lens == LensModel::kEquidistant) {
    return "fisheye";
  }
  return coefficients == 8 ? "rational_polynomial" : "plumb_bob";
}

Numbers row_by_row(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

Result<std::string> opencv_text(const RigCalibration& rig, const std::string& head) {
  if (rig.left.lens != rig.right.lens) {
    return fail(ErrorCode::kUnsupported,
                rig.source + ": an OpenCV file has one kind of lens for both views; write a Kalibr camchain");
  }
  const std::size_t coefficients = std::max(coefficient_count(rig.left), coefficient_count(rig.right));
  const Eigen::Vector3d& t = rig.T_right_left.translation;
  return concat("%YAML:1.0\n---\n", head, "image_width: ", std::to_string(rig.left.width_px),
                "\nimage_height: ", std::to_string(rig.left.height_px),
                "\ndistortion_model: ", opencv_lens(rig.left.lens, coefficients), "\n",
                opencv_camera("1", rig.left, coefficients), opencv_camera("2", rig.right, coefficients),
                "# From left to right, metres: p_right = R * p_left + T\n",
                opencv_matrix("R", 3, row_by_row(rig.T_right_left.rotation)),
                opencv_matrix("T", 1, {t.x(), t.y(), t.z()}));
}

std::string kalibr_camera(const CameraModel& camera) {
  return concat(
      "  camera_model: pinhole\n  intrinsics: ", bracketed({camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px}),
      "\n  distortion_model: ", camera.lens == LensModel::kEquidistant ? "equidistant" : "radtan",
      "\n  distortion_coeffs: ", bracketed(distortion(camera, 4)), "\n  resolution: [", std::to_string(camera.width_px),
      ", ", std::to_string(camera.height_px), "]\n");
}

Result<std::string> kalibr_text(const RigCalibration& rig, const std::string& head) {
  if (coefficient_count(rig.left) > 4 || coefficient_count(rig.right) > 4) {
    return fail(ErrorCode::kUnsupported,
                rig.source + ": a Kalibr camchain has k1 k2 p1 p2 of a lens, this one has more; write an OpenCV file");
  }
  const Eigen::Matrix3d& R = rig.T_right_left.rotation;
  const Eigen::Vector3d& t = rig.T_right_left.translation;
  std::string pose;
  for (int row = 0; row < 3; ++row) {
    pose += "  - " + bracketed({R(row, 0), R(row, 1), R(row, 2), t(row)}) + "\n";
  }
  return concat(head, "cam0:\n", kalibr_camera(rig.left), "  cam_overlaps: [1]\ncam1:\n", kalibr_camera(rig.right),
                "  cam_overlaps: [0]\n  T_cn_cnm1:\n", pose, "  - [0, 0, 0, 1]\n");
}

CameraModel without_distortion(const StereoGeometry& geometry) {
  return {.width_px = geometry.width_px,
          .height_px = geometry.height_px,
          .fx_px = geometry.fx_px,
          .fy_px = geometry.fy_px,
          .cx_px = geometry.cx_px,
          .cy_px = geometry.cy_px};
}

// p_rectified = R_left * p_left, and the same point from the right view's centre is R_right * p_right.
Se3 pose_of(const RectifyingTransforms& given) {
  const auto centre = [](const Eigen::Matrix<double, 3, 4>& P) -> Eigen::Vector3d {
    return -(P.leftCols<3>().inverse() * P.col(3));
  };
  const Eigen::Matrix3d back = given.R_right.transpose();
  return {back * given.R_left, back * (centre(given.P_left) - centre(given.P_right))};
}

// By content: whatever the name's extension is, YAML will be written.
template <bool (*is_kind)(const YamlDocument&)>
bool holds(const std::filesystem::path& path) {
  const auto document = read_text(path, kMaxCalibrationBytes).and_then([&path](std::string text) {
    return YamlDocument::parse(path, std::move(text));
  });
  return document && is_kind(*document);
}

}  // namespace

RigCalibration to_raw_rig(const RigCalibration& rig) {
  RigCalibration raw = rig;
  if (rig.rectified) {
    raw.left = raw.right = without_distortion(*rig.rectified);
    raw.T_right_left = {Eigen::Matrix3d::Identity(), {-rig.rectified->baseline_m, 0.0, 0.0}};
  } else if (rig.given) {
    raw.T_right_left = pose_of(*rig.given);
  }
  raw.rectified.reset();
  raw.given.reset();
  return raw;
}

Result<std::string> rig_calibration_text(const RigCalibration& rig, CalibrationFormat format,
                                         std::span<const std::string> remarks) {
  RigCalibration raw = to_raw_rig(rig);
  if (const Status valid = raw.validate(); !valid) {
    return Unexpected(valid.error());
  }
  return format == CalibrationFormat::kKalibr ? kalibr_text(raw, comments(remarks))
                                              : opencv_text(raw, comments(remarks));
}

Status write_rig_calibration(const RigCalibration& rig, const std::filesystem::path& path, CalibrationFormat format,
                             std::span<const std::string> remarks) {
  return rig_calibration_text(rig, format, remarks).and_then([&path](const std::string& text) {
    return replace_file(path, text);
  });
}

Status check_calibration_place(const std::filesystem::path& path, CalibrationFormat format) {
  const FileKind kind = format == CalibrationFormat::kKalibr
                            ? FileKind{"camchain of Kalibr", &holds<&is_kalibr_camchain>}
                            : FileKind{"calibration in OpenCV's YAML", &holds<&is_opencv_stereo>};
  return first_failure({check_replaceable(path), check_same_kind(path, kind)});
}

}  // namespace kinetrace::hal

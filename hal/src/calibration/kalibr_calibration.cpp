#include "calibration/calibration_files.hpp"
#include "util/first_error.hpp"
#include "util/messages.hpp"
#include "util/whole_pixels.hpp"

namespace kinetrace::hal {
namespace {

Result<CameraModel> read_camera(const YamlDocument& file, const std::string& camera) {
  const auto model = file.text(camera + ".camera_model");
  const auto lens = file.text(camera + ".distortion_model");
  const auto intrinsics = file.numbers(camera + ".intrinsics", 4);
  const auto size = file.numbers(camera + ".resolution", 2);
  if (const Error* error = first_error(model, lens, intrinsics, size)) {
    return Unexpected(*error);
  }
  if (*model != "pinhole") {
    return file.error(camera + ".camera_model", concat("is '", *model, "'; calibrate with the pinhole model"));
  }
  if (*lens != "radtan" && *lens != "equidistant" && *lens != "none") {
    return file.error(camera + ".distortion_model", concat("is '", *lens, "'; use radtan, equidistant or none"));
  }
  CameraModel result{.lens = *lens == "equidistant" ? LensModel::kEquidistant : LensModel::kRadialTangential,
                     .width_px = whole_pixels((*size)[0]),
                     .height_px = whole_pixels((*size)[1]),
                     .fx_px = (*intrinsics)[0],
                     .fy_px = (*intrinsics)[1],
                     .cx_px = (*intrinsics)[2],
                     .cy_px = (*intrinsics)[3]};
  if (*lens != "none") {
    const auto coefficients = file.numbers(camera + ".distortion_coeffs", 4);
    if (!coefficients) {
      return Unexpected(coefficients.error());
    }
    std::copy(coefficients->begin(), coefficients->end(), result.distortion.begin());
  }
  return result;
}

}  // namespace

bool is_kalibr_camchain(const YamlDocument& file) {
  return file.has("cam0.intrinsics") && file.has("cam1.intrinsics");
}

Result<RigCalibration> read_kalibr_camchain(const YamlDocument& file) {
  const auto left = read_camera(file, "cam0");
  const auto right = read_camera(file, "cam1");
  const auto T_right_left = file.transform("cam1.T_cn_cnm1");
  if (const Error* error = first_error(left, right, T_right_left)) {
    return Unexpected(*error);
  }
  RigCalibration rig;
  rig.source = file.path().string();
  rig.left = *left;
  rig.right = *right;
  rig.T_right_left = *T_right_left;
  return rig;
}

}  // namespace kinetrace::hal

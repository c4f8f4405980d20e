#include "calibration/calibration_files.hpp"
#include "util/first_error.hpp"
#include "util/messages.hpp"
#include "util/row_major.hpp"
#include "util/whole_pixels.hpp"

namespace kinetrace::hal {
namespace {

struct RosCamera {
  CameraModel model;
  Eigen::Matrix3d R;
  Eigen::Matrix<double, 3, 4> P;
};

Result<RosCamera> read_camera(const YamlDocument& file) {
  const auto width = file.numbers("image_width", 1);
  const auto height = file.numbers("image_height", 1);
  const auto K = file.matrix3("camera_matrix");
  const auto lens = file.text("distortion_model");
  const auto coefficients = file.numbers("distortion_coefficients");
  const auto R = file.matrix3("rectification_matrix");
  const auto P = file.numbers("projection_matrix", 12);
  if (const Error* error = first_error(width, height, K, lens, coefficients, R, P)) {
    return Unexpected(*error);
  }
  RosCamera camera;
  if (*lens == "equidistant" || *lens == "fisheye") {
    camera.model.lens = LensModel::kEquidistant;
  } else if (*lens != "plumb_bob" && *lens != "rational_polynomial") {
    return file.error("distortion_model",
                      concat("is '", *lens, "'; use plumb_bob, rational_polynomial or equidistant"));
  }
  camera.model.width_px = whole_pixels(width->front());
  camera.model.height_px = whole_pixels(height->front());
  camera.model.fx_px = (*K)(0, 0);
  camera.model.fy_px = (*K)(1, 1);
  camera.model.cx_px = (*K)(0, 2);
  camera.model.cy_px = (*K)(1, 2);
  if (const Status set = set_distortion(camera.model, *coefficients, file, "distortion_coefficients"); !set) {
    return Unexpected(set.error());
  }
  camera.R = *R;
  camera.P = row_major<3, 4>(*P);
  return camera;
}

}  // namespace

bool is_ros_camera_info(const YamlDocument& file) {
  return file.has("camera_matrix") && file.has("rectification_matrix") && file.has("projection_matrix");
}

Result<RigCalibration> read_ros_camera_infos(const YamlDocument& left_file, const YamlDocument& right_file) {
  const auto left = read_camera(left_file);
  const auto right = read_camera(right_file);
  if (const Error* error = first_error(left, right)) {
    return Unexpected(*error);
  }
  RigCalibration rig;
  rig.source = concat(left_file.path().string(), ", ", right_file.path().string());
  rig.left = left->model;
  rig.right = right->model;
  rig.given = RectifyingTransforms{left->R, right->R, left->P, right->P, left->model.width_px, left->model.height_px};
  return rig;
}

}  // namespace kinetrace::hal

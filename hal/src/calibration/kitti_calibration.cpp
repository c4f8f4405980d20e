#include "calibration/kitti_calibration.hpp"

#include <cmath>

#include "util/first_error.hpp"
#include "util/messages.hpp"
#include "util/row_major.hpp"
#include "util/text_file.hpp"
#include "util/whole_pixels.hpp"

namespace kinetrace::hal {
namespace {

Result<ImageSize> size_of(const KittiCalibrationFile& file, const std::string& key) {
  return file.numbers(key, 2).transform([](const std::vector<double>& values) {
    return ImageSize{whole_pixels(values[0]), whole_pixels(values[1])};
  });
}

bool same(const ImageSize& a, const ImageSize& b) {
  return a.width_px == b.width_px && a.height_px == b.height_px;
}

Result<CameraModel> camera(const KittiCalibrationFile& file, const std::string& id) {
  const auto size = size_of(file, "S_" + id);
  const auto K = file.matrix3("K_" + id);
  const auto D = file.numbers("D_" + id, 5);
  if (const Error* error = first_error(size, K, D)) {
    return Unexpected(*error);
  }
  CameraModel model{.width_px = size->width_px,
                    .height_px = size->height_px,
                    .fx_px = (*K)(0, 0),
                    .fy_px = (*K)(1, 1),
                    .cx_px = (*K)(0, 2),
                    .cy_px = (*K)(1, 2)};
  std::copy(D->begin(), D->end(), model.distortion.begin());
  return model;
}

}  // namespace

Result<KittiCalibrationFile> KittiCalibrationFile::load(const std::filesystem::path& path) {
  const Result<std::string> text = read_text(path, kMaxCalibrationBytes);
  if (!text) {
    return Unexpected(text.error());
  }
  KittiCalibrationFile file;
  file.path_ = path;
  for (const std::string_view line : content_lines(*text)) {
    // The tracking benchmark leaves out the colon after some keys.
    const std::size_t key_end = std::min(line.find_first_of(": \t"), line.size());
    std::string key(line.substr(0, key_end));
    const std::size_t value_begin = std::min(line.find_first_not_of(": \t", key_end), line.size());
    if (!file.values_.emplace(key, line.substr(value_begin)).second) {
      return fail(ErrorCode::kBadCalibration, concat(path.string(), ": '", key, "' is there twice; remove one"));
    }
  }
  return file;
}

Result<std::vector<double>> KittiCalibrationFile::numbers(const std::string& key, std::size_t count) const {
  const auto found = values_.find(key);
  const auto bad = [&](const std::string& what) {
    return fail(ErrorCode::kBadCalibration, concat(source(), ": '", key, "' ", what));
  };
  if (found == values_.end()) {
    return bad("is missing; the file is not the calibration of these cameras");
  }
  auto values = parse_numbers(found->second);
  if (!values || values->size() != count) {
    return bad(concat("must be ", std::to_string(count), " numbers"));
  }
  for (const double value : *values) {
    if (!std::isfinite(value)) {
      return bad(concat("holds ", number(value), ", which is no finite number; calibrate again"));
    }
  }
  return *values;
}

Result<Eigen::Matrix3d> KittiCalibrationFile::matrix3(const std::string& key) const {
  return numbers(key, 9).transform(row_major<3, 3>);
}

Result<Eigen::Matrix<double, 3, 4>> KittiCalibrationFile::projection(const std::string& key) const {
  return numbers(key, 12).transform(row_major<3, 4>);
}

Result<RigCalibration> kitti_rectified(const KittiCalibrationFile& file, const std::string& left_key,
                                       const std::string& right_key, const ImageSize& size) {
  const auto P_left = file.projection(left_key);
  const auto P_right = file.projection(right_key);
  if (const Error* error = first_error(P_left, P_right)) {
    return Unexpected(*error);
  }
  const auto geometry = geometry_from_projections(*P_left, *P_right, size.width_px, size.height_px, file.source());
  if (!geometry) {
    return Unexpected(geometry.error());
  }
  RigCalibration rig;
  rig.source = file.source();
  rig.rectified = *geometry;
  return rig;
}

Result<RigCalibration> kitti_raw_rig(const KittiCalibrationFile& file, const std::string& left,
                                     const std::string& right, const ImageSize& size, bool prefer_raw) {
  const auto raw_size = size_of(file, "S_" + left);
  const auto rectified_size = size_of(file, "S_rect_" + left);
  if (const Error* error = first_error(raw_size, rectified_size)) {
    return Unexpected(*error);
  }
  const bool fits_raw = same(size, *raw_size);
  const bool fits_rectified = same(size, *rectified_size);
  if (!fits_raw && !fits_rectified) {
    return fail(
        ErrorCode::kBadCalibration,
        concat(file.source(), ": is for images of ", size_text(raw_size->width_px, raw_size->height_px), " (raw) or ",
               size_text(rectified_size->width_px, rectified_size->height_px), " (rectified), but these are ",
               size_text(size.width_px, size.height_px), "; use the calibration of the day of the drive"));
  }
  if (fits_rectified && !(fits_raw && prefer_raw)) {
    return kitti_rectified(file, "P_rect_" + left, "P_rect_" + right, size);
  }
  const auto left_camera = camera(file, left);
  const auto right_camera = camera(file, right);
  const auto R_left = file.matrix3("R_rect_" + left);
  const auto R_right = file.matrix3("R_rect_" + right);
  const auto P_left = file.projection("P_rect_" + left);
  const auto P_right = file.projection("P_rect_" + right);
  if (const Error* error = first_error(left_camera, right_camera, R_left, R_right, P_left, P_right)) {
    return Unexpected(*error);
  }
  RigCalibration rig;
  rig.source = file.source();
  rig.left = *left_camera;
  rig.right = *right_camera;
  rig.given =
      RectifyingTransforms{*R_left, *R_right, *P_left, *P_right, rectified_size->width_px, rectified_size->height_px};
  return rig;
}

}  // namespace kinetrace::hal

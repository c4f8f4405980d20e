#include <algorithm>

#include "calibration/calibration_files.hpp"
#include "util/first_error.hpp"
#include "util/messages.hpp"
#include "util/whole_pixels.hpp"

namespace kinetrace::hal {
namespace {

using Keys = std::vector<std::string>;

Keys intrinsics_keys(const std::string& view) {
  return {"K" + view, "M" + view, "cameraMatrix" + view, "camera_matrix_" + view, "CM" + view};
}
Keys distortion_keys(const std::string& view) {
  return {"D" + view, "distCoeffs" + view, "distortion_coefficients_" + view, "dist_coeffs_" + view};
}

// A value, found in one of the files under one of the spellings.
struct Place {
  const YamlDocument* file;
  std::string key;
};

Result<Place> find(const std::vector<YamlDocument>& files, const Keys& keys) {
  for (const YamlDocument& file : files) {
    if (std::string key = file.first_of(keys); !key.empty()) {
      return Place{&file, std::move(key)};
    }
  }
  return files.front().error(keys.front(),
                             concat("is missing (looked for ", listed(keys), "); save the whole calibration"));
}

// The files of one calibration complement each other. The same key in two files means two calibrations, one of them
// perhaps outdated.
Status require_unique_key(const std::vector<YamlDocument>& files, const Keys& keys) {
  const YamlDocument* first = nullptr;
  for (const YamlDocument& file : files) {
    if (file.first_of(keys).empty()) {
      continue;
    }
    if (first != nullptr) {
      return fail(ErrorCode::kBadCalibration,
                  concat(first->path().string(), " and ", file.path().string(), " both hold ", keys.front(),
                         "; keep the calibration of these images alone"));
    }
    first = &file;
  }
  return {};
}

Result<Eigen::Matrix3d> find_matrix3(const std::vector<YamlDocument>& files, const Keys& keys) {
  return find(files, keys).and_then([](const Place& place) { return place.file->matrix3(place.key); });
}

bool is_fisheye(const std::vector<YamlDocument>& files) {
  const auto place = find(files, {"distortion_model", "camera_model", "model"});
  const auto name = place ? place->file->text(place->key) : Result<std::string>(std::string());
  return name && (*name == "fisheye" || *name == "equidistant" || *name == "KANNALA_BRANDT");
}

Result<ImageSize> image_size(const std::vector<YamlDocument>& files, const ImageSize& of_images) {
  const auto to_size = [](double width, double height) { return ImageSize{whole_pixels(width), whole_pixels(height)}; };
  if (const auto place = find(files, {"imageSize", "image_size", "size", "resolution"})) {
    return place->file->numbers(place->key, 2).transform([&](const std::vector<double>& v) {
      return to_size(v[0], v[1]);
    });
  }
  const auto width = find(files, {"image_width", "width"});
  const auto height = find(files, {"image_height", "height"});
  if (!width || !height) {
    return of_images;
  }
  const auto width_px = width->file->numbers(width->key, 1);
  const auto height_px = height->file->numbers(height->key, 1);
  if (const Error* error = first_error(width_px, height_px)) {
    return Unexpected(*error);
  }
  return to_size(width_px->front(), height_px->front());
}

Result<CameraModel> read_camera(const std::vector<YamlDocument>& files, const std::string& view, LensModel lens,
                                const ImageSize& size) {
  const auto K = find_matrix3(files, intrinsics_keys(view));
  const auto place = find(files, distortion_keys(view));
  if (const Error* error = first_error(K, place)) {
    return Unexpected(*error);
  }
  const auto coefficients = place->file->numbers(place->key);
  if (!coefficients) {
    return Unexpected(coefficients.error());
  }
  CameraModel camera{.lens = lens,
                     .width_px = size.width_px,
                     .height_px = size.height_px,
                     .fx_px = (*K)(0, 0),
                     .fy_px = (*K)(1, 1),
                     .cx_px = (*K)(0, 2),
                     .cy_px = (*K)(1, 2)};
  if (const Status set = set_distortion(camera, *coefficients, *place->file, place->key); !set) {
    return Unexpected(set.error());
  }
  return camera;
}

}  // namespace

std::optional<std::string> distortion_problem(CameraModel& camera, const std::vector<double>& coefficients) {
  const std::size_t known = camera.lens == LensModel::kEquidistant ? 4 : camera.distortion.size();
  const bool usual = coefficients.empty() || coefficients.size() == 4 || coefficients.size() == 5 ||
                     coefficients.size() == 8 || coefficients.size() == 12 || coefficients.size() == 14;
  if (!usual) {
    return concat("must be 4, 5 or 8 numbers, got ", std::to_string(coefficients.size()));
  }
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    if (i < known) {
      camera.distortion[i] = coefficients[i];
    } else if (coefficients[i] != 0.0) {
      return concat("has more than ", std::to_string(known),
                    " coefficients (thin prism, tilt), which is not supported; calibrate without them");
    }
  }
  return std::nullopt;
}

Status set_distortion(CameraModel& camera, const std::vector<double>& coefficients, const YamlDocument& file,
                      std::string_view key) {
  const auto problem = distortion_problem(camera, coefficients);
  return problem ? Status(file.error(key, *problem)) : Status();
}

bool is_opencv_stereo(const YamlDocument& file) {
  return !file.first_of(intrinsics_keys("1")).empty() || (file.has("R") && file.has("T"));
}

Result<RigCalibration> read_opencv_stereo(const std::vector<YamlDocument>& files, const ImageSize& size) {
  for (const Keys& keys : {intrinsics_keys("1"), intrinsics_keys("2"), Keys{"R"}, Keys{"T"}}) {
    if (const Status unique = require_unique_key(files, keys); !unique) {
      return Unexpected(unique.error());
    }
  }
  const LensModel lens = is_fisheye(files) ? LensModel::kEquidistant : LensModel::kRadialTangential;
  const auto stored_size = image_size(files, size);
  if (!stored_size) {
    return Unexpected(stored_size.error());
  }
  const auto left = read_camera(files, "1", lens, *stored_size);
  const auto right = read_camera(files, "2", lens, *stored_size);
  const auto R = find_matrix3(files, {"R"});
  const auto T = find(files, {"T"}).and_then([](const Place& place) { return place.file->numbers(place.key, 3); });
  if (const Error* error = first_error(left, right, R, T)) {
    return Unexpected(*error);
  }
  RigCalibration rig;
  for (const YamlDocument& file : files) {
    rig.source += (rig.source.empty() ? "" : ", ") + file.path().string();
  }
  rig.left = *left;
  rig.right = *right;
  rig.T_right_left = {*R, {(*T)[0], (*T)[1], (*T)[2]}};
  return rig;
}

}  // namespace kinetrace::hal

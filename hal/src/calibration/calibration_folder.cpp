// Finds the only calibration among the files beside the images, or among those that a camera's configuration names.
#include <algorithm>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "calibration/calibration_files.hpp"
#include "calibration/kitti_calibration.hpp"
#include "util/image_folder.hpp"
#include "util/messages.hpp"
#include "util/text_file.hpp"

namespace kinetrace::hal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLookedFor =
    "an OpenCV stereo calibration (K1, D1, K2, D2, R, T), a Kalibr camchain (cam0, cam1) or a pair of ROS CameraInfo "
    "files "
    "(left.yaml, right.yaml) in *.yaml, *.yml or *.xml";

std::vector<YamlDocument> only(const std::vector<YamlDocument>& all, bool (*is_kind)(const YamlDocument&)) {
  std::vector<YamlDocument> some;
  std::copy_if(all.begin(), all.end(), std::back_inserter(some), is_kind);
  return some;
}

Result<RigCalibration> read_ros_pair(const std::vector<YamlDocument>& files) {
  const auto view = [&files](std::string_view side) -> const YamlDocument* {
    const auto found = std::find_if(files.begin(), files.end(), [side](const YamlDocument& file) {
      return file.path().stem().string().find(side) != std::string::npos;
    });
    return found == files.end() ? nullptr : &*found;
  };
  const YamlDocument* left = view("left");
  const YamlDocument* right = view("right");
  if (left == nullptr || right == nullptr || left == right || files.size() != 2) {
    return fail(
        ErrorCode::kBadCalibration,
        concat(files.front().path().string(), ": ROS CameraInfo needs one file per view, left.yaml and right.yaml, in ",
               files.front().path().parent_path().string()));
  }
  return read_ros_camera_infos(*left, *right);
}

Result<RigCalibration> read_document(const fs::path& path, const ImageSize& size) {
  return YamlDocument::load(path).and_then(
      [&](const YamlDocument& file) { return read_yaml_calibration(path, {file}, size); });
}

Result<RigCalibration> read_any(const fs::path& path, const ImageSize& size) {
  if (path.extension() == ".txt") {
    return KittiCalibrationFile::load(path).and_then(
        [&](const KittiCalibrationFile& file) { return kitti_raw_rig(file, "00", "01", size, true); });
  }
  if (path.extension() == ".conf" || path.extension() == ".json") {
    return read_text(path, kMaxCalibrationBytes).and_then([&](const std::string& text) {
      if (path.extension() == ".conf") {
        return read_zed_calibration(path, text, size);
      }
      return is_depthai_calibration(text) ? read_depthai_calibration(path, text, size) : read_document(path, size);
    });
  }
  if (is_folder(path)) {
    return load_yaml_files(path).and_then(
        [&](const std::vector<YamlDocument>& files) { return read_yaml_calibration(path, files, size); });
  }
  return read_document(path, size);
}

bool is_same(const CameraModel& a, const CameraModel& b) {
  return a.lens == b.lens && a.width_px == b.width_px && a.height_px == b.height_px && a.fx_px == b.fx_px &&
         a.fy_px == b.fy_px && a.cx_px == b.cx_px && a.cy_px == b.cy_px && a.distortion == b.distortion;
}

bool is_same(const RigCalibration& a, const RigCalibration& b) {
  constexpr double kRounding = 1e-12;
  return is_same(a.left, b.left) && is_same(a.right, b.right) &&
         a.T_right_left.rotation.isApprox(b.T_right_left.rotation, kRounding) &&
         a.T_right_left.translation.isApprox(b.T_right_left.translation, kRounding);
}

/// A calibration that is there in OpenCV's and Kalibr's form, as kinetrace calibrate writes it; none if the two differ.
std::optional<RigCalibration> read_both_forms(const std::vector<YamlDocument>& opencv, const YamlDocument& kalibr,
                                              const ImageSize& size) {
  Result<RigCalibration> rig = read_opencv_stereo(opencv, size);
  const Result<RigCalibration> other = read_kalibr_camchain(kalibr);
  return rig && other && is_same(*rig, *other) ? std::optional(std::move(*rig)) : std::nullopt;
}

Unexpected<Error> several_calibrations(const fs::path& root, const std::vector<std::vector<YamlDocument>>& kinds) {
  std::string names;
  for (const std::vector<YamlDocument>& files : kinds) {
    for (const YamlDocument& file : files) {
      names += (names.empty() ? "" : ", ") + file.path().filename().string();
    }
  }
  return fail(ErrorCode::kBadCalibration, concat(root.string(), ": holds several calibrations: ", names, "; keep one"));
}

}  // namespace

Result<std::vector<YamlDocument>> load_yaml_files(const fs::path& folder) {
  std::vector<fs::path> paths;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const fs::path extension = entry->path().extension();
    if (extension == ".yaml" || extension == ".yml" || extension == ".xml") {
      paths.push_back(entry->path());
    }
  }
  std::sort(paths.begin(), paths.end());
  std::vector<YamlDocument> documents;
  for (const fs::path& path : paths) {
    auto document = YamlDocument::load(path);
    if (!document) {
      return Unexpected(document.error());
    }
    documents.push_back(std::move(*document));
  }
  return documents;
}

Result<RigCalibration> read_yaml_calibration(const fs::path& root, const std::vector<YamlDocument>& files,
                                             const ImageSize& size) {
  const auto kalibr = only(files, is_kalibr_camchain);
  const auto ros = only(files, is_ros_camera_info);
  const auto opencv = only(files, is_opencv_stereo);
  const int kinds =
      static_cast<int>(!kalibr.empty()) + static_cast<int>(!ros.empty()) + static_cast<int>(!opencv.empty());
  if (kinds == 0) {
    return fail(ErrorCode::kNotFound, concat("no calibration: looked in ", root.string(), " for ", kLookedFor));
  }
  if (kinds > 1 || kalibr.size() > 1 || opencv.size() > 2) {
    std::optional<RigCalibration> rig;
    if (ros.empty() && kalibr.size() == 1 && opencv.size() <= 2) {
      rig = read_both_forms(opencv, kalibr.front(), size);
    }
    return rig ? Result<RigCalibration>(std::move(*rig)) : several_calibrations(root, {kalibr, ros, opencv});
  }
  if (!kalibr.empty()) {
    return read_kalibr_camchain(kalibr.front());
  }
  return ros.empty() ? read_opencv_stereo(opencv, size) : read_ros_pair(ros);
}

Result<RigCalibration> read_rig_calibration(const fs::path& path, int width_px, int height_px) {
  Result<RigCalibration> rig = read_any(path, {width_px, height_px});
  if (!rig) {
    return rig;
  }
  if (const Status valid = rig->validate(); !valid) {
    return Unexpected(valid.error());
  }
  if (rig->raw_width_px() != width_px || rig->raw_height_px() != height_px) {
    return fail(
        ErrorCode::kBadCalibration,
        concat(rig->source, ": is for images of ", size_text(rig->raw_width_px(), rig->raw_height_px()),
               ", the camera delivers ", size_text(width_px, height_px), "; calibrate in the mode that is used"));
  }
  return rig;
}

}  // namespace kinetrace::hal

// A plain pair of folders with the calibration files of OpenCV, Kalibr or ROS beside them.
#include <array>

#include "calibration_files.hpp"
#include "dataset_builder.hpp"
#include "first_error.hpp"
#include "layouts.hpp"
#include "messages.hpp"

namespace kinetrace::hal {
namespace {

namespace fs = std::filesystem;

constexpr double kRate_hz = 10.0;
constexpr const char* kLookedFor =
    "an OpenCV stereo calibration (K1, D1, K2, D2, R, T), a Kalibr camchain (cam0, cam1) or a pair of ROS CameraInfo "
    "files "
    "(left.yaml, right.yaml) in *.yaml or *.yml";

const std::array<EyePair, 6>& known_eyes() {
  static const std::array<EyePair, 6> eyes{{{"left", "right"},
                                            {"image_0", "image_1"},
                                            {"cam0", "cam1"},
                                            {"image_00", "image_01"},
                                            {"image_2", "image_3"},
                                            {"image_left", "image_right"}}};
  return eyes;
}

Result<EyePair> find_eyes(const fs::path& root) {
  std::vector<std::string> looked_for;
  for (const EyePair& eyes : known_eyes()) {
    if (is_folder(root / eyes.left) && is_folder(root / eyes.right)) {
      return eyes;
    }
    looked_for.push_back(eyes.left + " + " + eyes.right);
  }
  return fail(ErrorCode::kNotFound, concat(root.string(), ": no pair of image folders (looked for ", listed(looked_for),
                                           "); put left images in left and right ones in right"));
}

fs::path images_below(const fs::path& eye) {
  return is_folder(eye / "data") ? eye / "data" : eye;
}

fs::path times_file(const fs::path& root, const fs::path& left) {
  for (const fs::path& path : {root / "times.txt", root / "timestamps.txt", left / "timestamps.txt"}) {
    if (is_file(path)) {
      return path;
    }
  }
  return {};
}

// All YAML files of a folder, sorted by name. The first that is damaged fails the whole: better than to miss it.
Result<std::vector<YamlDocument>> load_yaml_files(const fs::path& folder) {
  std::vector<fs::path> paths;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const fs::path extension = entry->path().extension();
    if (extension == ".yaml" || extension == ".yml") {
      paths.push_back(entry->path());
    }
  }
  std::sort(paths.begin(), paths.end());
  std::vector<YamlDocument> documents;
  for (const fs::path& path : paths) {
    auto document = YamlDocument::load(path);
    if (!document) {
      return tl::unexpected(document.error());
    }
    documents.push_back(std::move(*document));
  }
  return documents;
}

std::vector<YamlDocument> only(const std::vector<YamlDocument>& all, bool (*is_kind)(const YamlDocument&)) {
  std::vector<YamlDocument> some;
  std::copy_if(all.begin(), all.end(), std::back_inserter(some), is_kind);
  return some;
}

Result<RigCalibration> read_ros_pair(const std::vector<YamlDocument>& files) {
  const auto eye = [&files](std::string_view side) -> const YamlDocument* {
    const auto found = std::find_if(files.begin(), files.end(), [side](const YamlDocument& file) {
      return file.path().stem().string().find(side) != std::string::npos;
    });
    return found == files.end() ? nullptr : &*found;
  };
  const YamlDocument* left = eye("left");
  const YamlDocument* right = eye("right");
  if (left == nullptr || right == nullptr || left == right || files.size() != 2) {
    return fail(
        ErrorCode::kBadCalibration,
        concat(files.front().path().string(), ": ROS CameraInfo needs one file per eye, left.yaml and right.yaml, in ",
               files.front().path().parent_path().string()));
  }
  return read_ros_camera_infos(*left, *right);
}

// The one calibration among the files.
Result<RigCalibration> read_calibration(const fs::path& root, const std::vector<YamlDocument>& files,
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
    return fail(ErrorCode::kBadCalibration, concat(root.string(), ": holds several calibrations; keep one"));
  }
  if (!kalibr.empty()) {
    return read_kalibr_camchain(kalibr.front());
  }
  return ros.empty() ? read_opencv_stereo(opencv, size) : read_ros_pair(ros);
}

}  // namespace

Result<Dataset> open_folder(const DatasetSpec& spec) {
  const fs::path root = spec.sequence.empty() ? spec.path : spec.path / spec.sequence;
  if (!is_folder(root)) {
    return fail(ErrorCode::kInvalidArgument, concat(spec.path.string(), ": no sequence '", spec.sequence,
                                                    "'; choose one: ", listed(subfolders(spec.path))));
  }
  const auto eyes = find_eyes(root);
  if (!eyes) {
    return tl::unexpected(eyes.error());
  }
  const fs::path left_folder = images_below(root / eyes->left);
  auto left = list_images(left_folder);
  auto right = list_images(images_below(root / eyes->right));
  const auto yaml_files = load_yaml_files(root);
  if (const Error* error = first_error(left, right, yaml_files)) {
    return tl::unexpected(*error);
  }
  const SequenceFiles files{std::move(*left), std::move(*right), times_file(root, root / eyes->left), kRate_hz};
  return build_dataset(fs::weakly_canonical(root).filename().string(), files, spec,
                       [&](const ImageSize& size) { return read_calibration(root, *yaml_files, size); });
}

}  // namespace kinetrace::hal

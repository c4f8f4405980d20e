// A plain pair of folders with the calibration files of OpenCV, Kalibr or ROS beside them.
#include <array>

#include "calibration/calibration_files.hpp"
#include "dataset/dataset_builder.hpp"
#include "dataset/layouts.hpp"
#include "util/first_error.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

namespace fs = std::filesystem;

constexpr double kRate_hz = 10.0;

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
    if (is_there(path)) {
      return path;
    }
  }
  return {};
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
    return Unexpected(eyes.error());
  }
  const fs::path left_folder = images_below(root / eyes->left);
  auto left = list_images(left_folder);
  auto right = list_images(images_below(root / eyes->right));
  const auto yaml_files = load_yaml_files(root);
  if (const Error* error = first_error(left, right, yaml_files)) {
    return Unexpected(*error);
  }
  const SequenceFiles files{std::move(*left), std::move(*right), times_file(root, root / eyes->left), kRate_hz};
  return build_dataset(fs::weakly_canonical(root).filename().string(), files, spec,
                       [&](const ImageSize& size) { return read_yaml_calibration(root, *yaml_files, size); });
}

}  // namespace kinetrace::hal

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

const std::array<ViewPair, 6>& known_views() {
  static const std::array<ViewPair, 6> views{{{"left", "right"},
                                              {"image_0", "image_1"},
                                              {"cam0", "cam1"},
                                              {"image_00", "image_01"},
                                              {"image_2", "image_3"},
                                              {"image_left", "image_right"}}};
  return views;
}

Result<ViewPair> find_views(const fs::path& root) {
  std::vector<std::string> looked_for;
  for (const ViewPair& views : known_views()) {
    if (is_folder(root / views.left) && is_folder(root / views.right)) {
      return views;
    }
    looked_for.push_back(views.left + " + " + views.right);
  }
  return fail(ErrorCode::kNotFound, concat(root.string(), ": no pair of image folders (looked for ", listed(looked_for),
                                           "); put left images in left and right ones in right"));
}

fs::path images_below(const fs::path& view) {
  return is_folder(view / "data") ? view / "data" : view;
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
                                                    "'; choose one with --sequence: ", listed(subfolders(spec.path))));
  }
  const auto views = find_views(root);
  if (!views) {
    return Unexpected(views.error());
  }
  const fs::path left_folder = images_below(root / views->left);
  auto left = list_images(left_folder);
  auto right = list_images(images_below(root / views->right));
  const auto yaml_files = spec.uncalibrated ? Result<std::vector<YamlDocument>>() : load_yaml_files(root);
  if (const Error* error = first_error(left, right, yaml_files)) {
    return Unexpected(*error);
  }
  const SequenceFiles files{std::move(*left), std::move(*right), times_file(root, root / views->left), kRate_hz};
  return build_dataset(fs::weakly_canonical(root).filename().string(), files, spec, [&](const ImageSize& size) {
    return spec.uncalibrated ? images_alone(size.width_px, size.height_px)
                             : read_yaml_calibration(root, *yaml_files, size);
  });
}

}  // namespace kinetrace::hal

// KITTI visual odometry benchmark: rectified sequences with calib.txt and times.txt.
#include "calibration/kitti_calibration.hpp"
#include "dataset/dataset_builder.hpp"
#include "dataset/layouts.hpp"
#include "util/first_error.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

namespace fs = std::filesystem;

constexpr double kRate_hz = 10.0;

bool is_sequence(const fs::path& path) {
  return is_folder(path / "image_0") || is_folder(path / "image_2");
}

Result<fs::path> find_sequence(const DatasetSpec& spec) {
  if (is_sequence(spec.path)) {
    return spec.path;
  }
  const fs::path root = is_folder(spec.path / "sequences") ? spec.path / "sequences" : spec.path;
  std::vector<std::string> sequences = subfolders(root);
  std::erase_if(sequences, [&root](const std::string& name) { return !is_sequence(root / name); });
  if (sequences.empty()) {
    return fail(ErrorCode::kNotFound, root.string() +
                                          ": no KITTI odometry sequence here (looked for image_0 or image_2 in it and "
                                          "below); give the sequence's folder");
  }
  return choose_sequence(root, spec.sequence, sequences).transform([&root](const std::string& name) {
    return root / name;
  });
}

}  // namespace

Result<Dataset> open_kitti_odometry(const DatasetSpec& spec) {
  const Result<fs::path> sequence = find_sequence(spec);
  if (!sequence) {
    return Unexpected(sequence.error());
  }
  const auto views = choose_views(*sequence, spec.cameras, {"image_0", "image_1"}, {"image_2", "image_3"});
  if (!views) {
    return Unexpected(views.error());
  }
  if (!is_file(*sequence / "calib.txt")) {
    return fail(ErrorCode::kNotFound,
                concat("no calibration: looked for ", (*sequence / "calib.txt").string(), "; copy it there"));
  }
  const auto calibration = KittiCalibrationFile::load(*sequence / "calib.txt");
  auto left = list_images(*sequence / views->left);
  auto right = list_images(*sequence / views->right);
  if (const Error* error = first_error(calibration, left, right)) {
    return Unexpected(*error);
  }
  const SequenceFiles files{std::move(*left), std::move(*right), *sequence / "times.txt", kRate_hz};
  return build_dataset(fs::weakly_canonical(*sequence).filename().string(), files, spec, [&](const ImageSize& size) {
    constexpr std::size_t kIdBegin = 6;  // "image_2" is camera "2" with "P2".
    return kitti_rectified(*calibration, concat("P", views->left.substr(kIdBegin)),
                           concat("P", views->right.substr(kIdBegin)), size);
  });
}

}  // namespace kinetrace::hal

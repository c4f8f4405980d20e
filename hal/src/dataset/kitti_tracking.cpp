// KITTI multi-object tracking benchmark: rectified colour sequences under image_02/SEQ and image_03/SEQ, calib/SEQ.txt.
#include "calibration/kitti_calibration.hpp"
#include "dataset/dataset_builder.hpp"
#include "dataset/layouts.hpp"
#include "util/first_error.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

namespace fs = std::filesystem;

constexpr double kRate_hz = 10.0;

// The folder with image_02: the path itself or its training/ or testing/.
Result<fs::path> find_root(const DatasetSpec& spec) {
  for (const char* below : {"", "training", "testing"}) {
    const fs::path root = *below == '\0' ? spec.path : spec.path / below;
    const bool wanted = spec.sequence.empty() || is_folder(root / "image_02" / spec.sequence);
    if (is_folder(root / "image_02") && wanted) {
      return root;
    }
  }
  if (is_folder(spec.path / "image_02")) {
    return spec.path;
  }
  return fail(ErrorCode::kNotFound, concat(spec.path.string(), ": no KITTI tracking data here (looked for image_02",
                                           spec.sequence.empty() ? "" : "/" + spec.sequence,
                                           " in it, in training and in testing); give the folder that holds image_02"));
}

}  // namespace

Result<Dataset> open_kitti_tracking(const DatasetSpec& spec) {
  if (spec.cameras == CameraChoice::kGray) {
    return fail(ErrorCode::kInvalidArgument,
                spec.path.string() + ": KITTI tracking has colour cameras only; choose color or auto");
  }
  const auto root = find_root(spec);
  if (!root) {
    return Unexpected(root.error());
  }
  const auto sequence = choose_sequence(*root / "image_02", spec.sequence, subfolders(*root / "image_02"));
  if (!sequence) {
    return Unexpected(sequence.error());
  }
  const fs::path calibration_path = *root / "calib" / (*sequence + ".txt");
  if (!is_file(calibration_path)) {
    return fail(ErrorCode::kNotFound, concat("no calibration: looked for ", calibration_path.string(),
                                             "; unpack the benchmark's calibration files there"));
  }
  const auto calibration = KittiCalibrationFile::load(calibration_path);
  auto left = list_images(*root / "image_02" / *sequence);
  auto right = list_images(*root / "image_03" / *sequence);
  if (const Error* error = first_error(calibration, left, right)) {
    return Unexpected(*error);
  }
  const SequenceFiles files{std::move(*left), std::move(*right), {}, kRate_hz};
  return build_dataset(*sequence, files, spec,
                       [&](const ImageSize& size) { return kitti_rectified(*calibration, "P2", "P3", size); });
}

}  // namespace kinetrace::hal

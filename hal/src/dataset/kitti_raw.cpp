// KITTI raw recordings (Geiger et al., "Vision meets robotics: the KITTI dataset", IJRR 2013).
#include "calibration/kitti_calibration.hpp"
#include "dataset/dataset_builder.hpp"
#include "dataset/layouts.hpp"
#include "util/first_error.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

namespace fs = std::filesystem;

constexpr double kRate_hz = 10.0;

bool is_drive(const fs::path& path) {
  return is_folder(path / "image_00") || is_folder(path / "image_02");
}

// "0039" finds "2011_09_26_drive_0039_extract".
bool is_called(const std::string& folder, const std::string& sequence) {
  return folder == sequence || folder.find("_drive_" + sequence + "_") != std::string::npos;
}

// The drive below a folder of one date, or below the root of all dates.
Result<fs::path> find_drive(const DatasetSpec& spec) {
  if (is_drive(spec.path)) {
    return spec.path;
  }
  std::vector<std::string> drives;
  std::vector<std::string> matches;
  const auto collect = [&](const fs::path& date, const fs::path& below) {
    for (const std::string& name : subfolders(date)) {
      if (is_drive(date / name)) {
        drives.push_back((below / name).string());
        // Also by the name in the list.
        if (spec.sequence.empty() || is_called(name, spec.sequence) || drives.back() == spec.sequence) {
          matches.push_back(drives.back());
        }
      }
    }
  };
  collect(spec.path, "");
  for (const std::string& date : subfolders(spec.path)) {
    collect(spec.path / date, date);
  }
  if (matches.size() == 1) {
    return spec.path / matches.front();
  }
  if (drives.empty()) {
    return fail(ErrorCode::kNotFound,
                spec.path.string() +
                    ": no KITTI raw drive here (looked for image_00 or image_02 in it and below); "
                    "give the drive's folder");
  }
  return fail(ErrorCode::kInvalidArgument,
              concat(spec.path.string(), matches.empty() ? ": no drive '" + spec.sequence + "'" : ": several drives",
                     "; choose one with --sequence: ", listed(matches.empty() ? drives : matches)));
}

Result<KittiCalibrationFile> find_calibration(const fs::path& drive) {
  const fs::path absolute = fs::weakly_canonical(drive);
  for (const fs::path& folder : {absolute, absolute.parent_path()}) {
    if (is_file(folder / "calib_cam_to_cam.txt")) {
      return KittiCalibrationFile::load(folder / "calib_cam_to_cam.txt");
    }
  }
  return fail(ErrorCode::kNotFound,
              concat("no calibration: looked for calib_cam_to_cam.txt in ", absolute.string(), " and ",
                     absolute.parent_path().string(), "; copy the one of the drive's date there"));
}

// Images lie in data/, or directly in the camera's folder.
Result<ImageFolder> images_of(const fs::path& camera) {
  return list_images(is_folder(camera / "data") ? camera / "data" : camera);
}

}  // namespace

Result<Dataset> open_kitti_raw(const DatasetSpec& spec) {
  const Result<fs::path> drive = find_drive(spec);
  if (!drive) {
    return Unexpected(drive.error());
  }
  const auto views = choose_views(*drive, spec.cameras, {"image_00", "image_01"}, {"image_02", "image_03"});
  if (!views) {
    return Unexpected(views.error());
  }
  const auto calibration = find_calibration(*drive);
  if (!calibration && !spec.uncalibrated) {
    return Unexpected(calibration.error());
  }
  auto left = images_of(*drive / views->left);
  auto right = images_of(*drive / views->right);
  if (const Error* error = first_error(left, right)) {
    return Unexpected(*error);
  }
  const std::string name = fs::weakly_canonical(*drive).filename().string();
  const SequenceFiles files{.left = std::move(*left),
                            .right = std::move(*right),
                            .times_path = *drive / views->left / "timestamps.txt",
                            .rate_hz = kRate_hz,
                            .frame_times_path = *drive / kFrameTimesFile,
                            .right_times_path = *drive / views->right / "timestamps.txt"};
  return build_dataset(name, files, spec, [&](const ImageSize& size) {
    if (spec.uncalibrated) {
      return images_alone(size.width_px, size.height_px);
    }
    constexpr std::size_t kIdBegin = 6;  // "image_00" is camera "00".
    return kitti_raw_rig(*calibration, views->left.substr(kIdBegin), views->right.substr(kIdBegin), size,
                         name.ends_with("_extract"));
  });
}

}  // namespace kinetrace::hal

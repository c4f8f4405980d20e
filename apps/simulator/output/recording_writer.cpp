#include "output/recording_writer.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <iomanip>
#include <system_error>
#include <utility>
#include <vector>

#include "kinetrace/imaging/png_writer.hpp"
#include "output/truth_text.hpp"
#include "util/parallel.hpp"
#include "util/random.hpp"

namespace kinetrace::simulator {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDate = "2026_01_01";
constexpr std::array<const char*, 2> kSides{"left", "right"};
constexpr std::array<const char*, 2> kCameras{"image_00", "image_01"};

std::string file_name(int index) {
  std::string digits = std::to_string(index);
  return std::string(10 - digits.size(), '0') + digits + ".png";
}

// KITTI's depth maps: metres * 256, 0 where there is none.
Image<std::uint16_t> depth_levels(const Image<float>& depth_m) {
  Image<std::uint16_t> levels(depth_m.width(), depth_m.height());
  for (std::size_t i = 0; i < levels.pixels().size(); ++i) {
    const float level = depth_m.pixels()[i] * 256.F;
    // Rounded without a function call, so that the compiler can vectorise the loop.
    const auto whole = static_cast<int>(std::min(level, 65536.F));
    const int rounded = whole + (level - static_cast<float>(whole) >= 0.5F ? 1 : 0);
    levels.pixels()[i] = static_cast<std::uint16_t>(rounded > 65535 ? 0 : rounded);
  }
  return levels;
}

// Replaces only folders of an earlier simulation; whether there was one.
Result<bool> clear_folder(const fs::path& folder) {
  std::error_code error;
  const bool empty = !fs::exists(folder, error) || fs::is_empty(folder, error);
  if (!empty && !fs::exists(folder / "truth" / "objects.csv", error)) {
    return fail(ErrorCode::kInvalidArgument,
                folder.string() + ": is not empty and holds no simulated sequence; choose another folder");
  }
  for (const fs::path& part : {folder / kDate, folder / "truth"}) {
    fs::remove_all(part, error);
    if (error) {
      return fail(ErrorCode::kIo, part.string() + ": cannot be removed (" + error.message() + ")");
    }
  }
  return !empty;
}

Status make_folders(const std::vector<fs::path>& folders) {
  for (const fs::path& folder : folders) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) {
      return fail(ErrorCode::kIo, folder.string() + ": cannot be made (" + error.message() + "); check the path");
    }
  }
  return {};
}

Status check_written(const std::ofstream& file, const fs::path& path) {
  return file ? Status{} : fail(ErrorCode::kIo, path.string() + ": cannot be written; check the free space");
}

}  // namespace

RecordingWriter::RecordingWriter(RecordingSettings settings, const StereoSimulator& simulator)
    : settings_(std::move(settings)),
      simulator_settings_(simulator.settings()),
      // As KITTI names them: "extract" is raw, "sync" is rectified.
      drive_(settings_.folder / kDate /
             (std::string(kDate) + "_drive_0001_" + (simulator.rig().distorted ? "extract" : "sync"))),
      truth_(settings_.folder / "truth") {}

Result<RecordingWriter> RecordingWriter::create(const RecordingSettings& settings, const StereoSimulator& simulator) {
  const Result<bool> replaced = clear_folder(settings.folder);
  if (!replaced) {
    return Unexpected(replaced.error());
  }
  RecordingWriter writer(settings, simulator);
  writer.replaced_ = *replaced;
  std::vector<fs::path> folders;
  for (std::size_t side = 0; side < 2; ++side) {
    folders.push_back(writer.drive_ / kCameras[side] / "data");
    for (const std::string kind : {"masks/instances_", "masks/detections_", "depth/"}) {
      folders.push_back(writer.truth_ / (kind + kSides[side]));
    }
  }
  if (const Status made = make_folders(folders); !made) {
    return Unexpected(made.error());
  }
  const fs::path calibration = writer.drive_.parent_path() / "calib_cam_to_cam.txt";
  std::ofstream calibration_file(calibration);
  calibration_file << calibration_text(miscalibrated(simulator.rig(), simulator.settings().errors.focal)) << std::flush;
  if (const Status written = check_written(calibration_file, calibration); !written) {
    return Unexpected(written.error());
  }
  for (std::size_t side = 0; side < 2; ++side) {
    writer.timestamps_[side].open(writer.drive_ / kCameras[side] / "timestamps.txt");
  }
  writer.camera_poses_.open(writer.truth_ / "camera_poses.txt");
  writer.camera_poses_ << std::scientific << std::setprecision(12);
  if (simulator.settings().errors.move_right_camera()) {
    writer.right_camera_.open(writer.truth_ / "right_camera.csv");
    writer.right_camera_ << std::setprecision(9) << kRightCameraHeader;
  }
  writer.objects_.open(writer.truth_ / "objects.csv");
  writer.objects_ << std::setprecision(12) << kObjectsHeader;
  writer.labels_.open(writer.truth_ / "label_02.txt");
  writer.labels_ << std::setprecision(9);
  return writer;
}

Status RecordingWriter::write_images(const SimulatedFrame& frame) const {
  std::vector<std::function<Status()>> files;
  const std::string name = file_name(frame.index);
  for (std::size_t side = 0; side < 2; ++side) {
    files.emplace_back([&, side] {
      return imaging::write_png_gray8((drive_ / kCameras[side] / "data" / name).c_str(), frame.pictures[side].view(),
                                      imaging::PngEffort::kFast);
    });
    files.emplace_back([&, side] {
      const Image<std::uint16_t> depth = depth_levels(frame.depth_m[side]);
      return imaging::write_png_gray16((truth_ / "depth" / kSides[side] / name).c_str(), depth.view(),
                                       imaging::PngEffort::kFast);
    });
    files.emplace_back([&, side] {
      return imaging::write_png_gray16((truth_ / "masks" / (std::string("instances_") + kSides[side]) / name).c_str(),
                                       frame.instances[side].view(), imaging::PngEffort::kFlat);
    });
    files.emplace_back([&, side] {
      const std::uint32_t stream = hash_of(simulator_settings_.seed, frame.index, side, 7);
      const Image<std::uint16_t> masks = settings_.degrade
                                             ? degraded_masks(frame.instances[side], settings_.degradation, stream)
                                             : shuffled_masks(frame.instances[side], stream);
      return imaging::write_png_gray16((truth_ / "masks" / (std::string("detections_") + kSides[side]) / name).c_str(),
                                       masks.view(), imaging::PngEffort::kFlat);
    });
  }
  std::vector<Status> outcomes(files.size());
  for_each_index(static_cast<int>(files.size()), simulator_settings_.threads,
                 [&](int i) { outcomes[static_cast<std::size_t>(i)] = files[static_cast<std::size_t>(i)](); });
  for (Status& outcome : outcomes) {
    if (!outcome) {
      return std::move(outcome);
    }
  }
  return {};
}

void RecordingWriter::write_rows(const SimulatedFrame& frame) {
  for (std::ofstream& file : timestamps_) {
    file << timestamp_text(frame.timestamp_ns) << '\n';
  }
  write_pose(frame.T_world_cam, camera_poses_);
  if (right_camera_.is_open()) {
    write_right_camera_row(frame, right_camera_);
  }
  for (const ObjectTruth& object : frame.objects) {
    write_object_row(frame, object, objects_);
    write_label(frame, object, labels_);
  }
}

Status RecordingWriter::write(const SimulatedFrame& frame) {
  write_rows(frame);
  return write_images(frame);
}

Status RecordingWriter::finish() {
  for (std::ofstream* file : {&timestamps_[0], &timestamps_[1], &camera_poses_, &right_camera_, &objects_, &labels_}) {
    if (!file->is_open()) {
      continue;
    }
    file->close();
    if (Status written = check_written(*file, settings_.folder); !written) {
      return written;
    }
  }
  return {};
}

}  // namespace kinetrace::simulator

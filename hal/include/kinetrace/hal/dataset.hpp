// Stereo recordings on disk, in the layouts they are published in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/frame_list.hpp"
#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::hal {

/// See hal/README.md for what each layout looks like.
enum class DatasetLayout : std::uint8_t {
  kKittiRaw,
  kKittiOdometry,
  kKittiTracking,
  kEuroc,
  kCityscapes,
  kFolder,
  kContainer
};

/// Names of the layouts that parse_layout accepts.
[[nodiscard]] KINETRACE_API std::span<const std::string_view> layout_names() noexcept;
[[nodiscard]] KINETRACE_API std::string_view to_string(DatasetLayout layout) noexcept;
/// From "kitti-raw", "kitti-odometry", "kitti-tracking", "euroc", "cityscapes", "folder" or "container". Errors:
/// kInvalidArgument.
[[nodiscard]] KINETRACE_API Result<DatasetLayout> parse_layout(std::string_view name);

/// Which of a rig's camera pairs to use; kAuto takes gray where there is a choice.
enum class CameraChoice : std::uint8_t { kAuto, kGray, kColor };

class ContainerRecording;

struct DatasetSpec {
  DatasetLayout layout = DatasetLayout::kFolder;
  std::filesystem::path path = {};
  std::string sequence = {};  ///< For paths that hold several; empty where there is only one.
  CameraChoice cameras = CameraChoice::kAuto;
  double frame_rate_hz = 0.0;  ///< For recordings without time stamps; 0: the layout's own (10, Cityscapes 17).
  /// Layouts of raw images (kitti-raw, folder) then read no calibration; that of the dataset holds the image size only,
  /// see images_alone.
  bool uncalibrated = false;
};

/// A recording, ready to be played: its calibration (validated) and its list of frames.
struct Dataset {
  std::string name;  ///< Name of the sequence, for reports.
  DatasetLayout layout = DatasetLayout::kFolder;
  RigCalibration calibration;
  FrameList frames;
  double nominal_rate_hz = 0.0;                         ///< One over the median time between frames.
  std::size_t max_file_bytes = 0;                       ///< Of the largest image file.
  int sample_bits = 16;                                 ///< Of 16-bit grey images: bits that the camera's values use.
  std::shared_ptr<const ContainerRecording> container;  ///< Holds the images, in the order of `frames`; else null.
  std::vector<std::string> notes;  ///< Assumptions, one line each: "no time stamps in X: 10 Hz assumed".
};

/// Finds the frames and the calibration. Reads file names, headers and text files, and a few images if these are 16-bit
/// grey. Errors, one line with the path and the remedy: kNotFound (folder, images or calibration; says what was looked
/// for), kInvalidArgument (sequence missing or ambiguous; lists the available ones), kBadCalibration, kBadFormat
/// (damaged text files, no readable pair, sizes that do not fit the calibration or each other), kUnsupported.
[[nodiscard]] KINETRACE_API Result<Dataset> open_dataset(const DatasetSpec& spec);

}  // namespace kinetrace::hal

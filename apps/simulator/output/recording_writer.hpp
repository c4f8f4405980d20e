// A simulated sequence on disk: a KITTI raw drive with the truth beside it.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "kinetrace/core/result.hpp"
#include "output/mask_degradation.hpp"
#include "rendering/stereo_simulator.hpp"

namespace kinetrace::simulator {

struct RecordingSettings {
  std::filesystem::path folder;
  bool degrade = true;  ///< Detections degraded as from a network; otherwise exact with shuffled ids.
  DegradationSettings degradation;
};

/// Writes a sequence; see README.md for the files. Frames are given in order.
class RecordingWriter {
 public:
  /// Makes the folders, replacing an earlier simulation. Errors: kInvalidArgument (the folder holds other things), kIo.
  [[nodiscard]] static Result<RecordingWriter> create(const RecordingSettings& settings,
                                                      const StereoSimulator& simulator);
  [[nodiscard]] Status write(const SimulatedFrame& frame);
  /// Closes the text files. Errors: kIo.
  [[nodiscard]] Status finish();

  [[nodiscard]] const std::filesystem::path& drive() const noexcept { return drive_; }
  /// Whether an earlier simulation was in the folder.
  [[nodiscard]] bool replaced() const noexcept { return replaced_; }

 private:
  RecordingWriter(RecordingSettings settings, const StereoSimulator& simulator);
  [[nodiscard]] Status write_images(const SimulatedFrame& frame) const;
  void write_rows(const SimulatedFrame& frame);

  RecordingSettings settings_;
  SimulatorSettings simulator_settings_;
  std::filesystem::path drive_;
  std::filesystem::path truth_;
  bool replaced_ = false;
  std::array<std::ofstream, 2> timestamps_;
  std::ofstream camera_poses_;
  std::ofstream right_camera_;  ///< Open only if the right camera's pose differs from its calibration.
  std::ofstream objects_;
  std::ofstream labels_;
};

}  // namespace kinetrace::simulator

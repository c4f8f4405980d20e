// A tiny rectified recording in KITTI odometry layout, made of noise: two walls that a camera passes sideways.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>

namespace kinetrace::test {

struct SmallRecording {
  static constexpr int kWidth = 416;
  static constexpr int kHeight = 256;
  static constexpr double kFocal = 300.0;
  static constexpr double kBaseline = 0.5;
  static constexpr double kStep = 0.05;  ///< Metres to the right from frame to frame.

  std::filesystem::path root;  ///< Argument of --dataset kitti-odometry:.
  int frames = 6;
  double step_m = kStep;
  bool turns_back = false;  ///< The second half of the frames returns to the start.
  int width_px = kWidth;
  int height_px = kHeight;
  bool uniform = false;           ///< One grey value, no texture.
  std::uint8_t brightness = 128;  ///< Of uniform images.

  [[nodiscard]] std::filesystem::path sequence() const { return root / "sequences" / "00"; }
  [[nodiscard]] std::filesystem::path calibration() const { return sequence() / "calib.txt"; }
  /// Position of the left camera in a frame.
  [[nodiscard]] double x_m(int frame) const {
    return step_m * (turns_back ? std::min(frame, frames - 1 - frame) : frame);
  }
  /// View 0 is left, 1 right.
  [[nodiscard]] std::filesystem::path image(int view, int frame) const;
  [[nodiscard]] std::string dataset() const { return "kitti-odometry:" + sequence().string(); }

  void write() const;
  /// Replaces calib.txt by one with these entries P[0][3] of the left and the right camera, as text.
  void write_calibration(const std::string& left_tx, const std::string& right_tx) const;
  /// Replaces an image by one of another size.
  void write_image_of_size(int view, int frame, int width, int height) const;
};

/// Cuts a file to its first `bytes` bytes.
void truncate_file(const std::filesystem::path& path, std::uintmax_t bytes);
/// Writes the size into a PNG's header, with a correct checksum, leaving the rest alone.
void forge_png_size(const std::filesystem::path& path, std::uint32_t width, std::uint32_t height);

}  // namespace kinetrace::test

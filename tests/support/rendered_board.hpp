// Images of a calibration target, seen by a rig with known lenses.
#pragma once

#include <cstdint>
#include <vector>

#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/hal/rig_calibration.hpp"
#include "target.hpp"

namespace kinetrace::test {

struct BoardImage {
  std::vector<std::uint8_t> pixels;
  int width_px = 0;
  int height_px = 0;

  [[nodiscard]] GrayView view() const { return {pixels.data(), width_px, height_px, width_px}; }
};

/// Degradations of an image.
struct BoardImageFaults {
  double blur_px = 0.6;     ///< Sigma of the lens and of motion.
  double noise_grey = 2.0;  ///< Sigma of a pixel.
  double covered = 0.0;     ///< Occluded part of the board's width, from its left edge.
};

/// Renders one target for one lens. Each pixel is the mean of 16 samples of the pattern.
class BoardRenderer {
 public:
  BoardRenderer(const calibration::Target& target, const hal::CameraModel& camera);

  [[nodiscard]] BoardImage render(const Se3& T_cam_board, const BoardImageFaults& faults, std::uint32_t seed) const;

 private:
  /// The printed board as an image.
  struct Print {
    std::vector<std::uint8_t> pixels;
    int width_px = 0;
    int height_px = 0;
    double px_per_m = 0.0;
    Eigen::Vector2d origin_m;  ///< Of its first pixel's corner, in the board's frame.

    void fill(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, std::uint8_t grey);
    [[nodiscard]] int grey_at(double x_m, double y_m) const;
  };

  class PosedPrint;

  [[nodiscard]] std::vector<float> draw(const Se3& T_cam_board, double covered_to_m) const;

  hal::CameraModel camera_;
  Print print_;
  std::vector<Eigen::Vector2d> rays_;  ///< Of pixel corners, one more than pixels each way; not finite: none.
  double covered_from_m_ = 0.0;
  double width_m_ = 0.0;
};

}  // namespace kinetrace::test

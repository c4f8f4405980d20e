// The lenses of the simulated rig: rectified by construction, or raw with the calibration that rectifies them.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::simulator {

enum class View : int { kLeft = 0, kRight = 1 };

/// Pinhole with radial-tangential distortion k1 k2 p1 p2 k3 (D. Brown, "Close-range camera calibration", 1971), turned
/// against the rectified camera: p_rect = R_rect * p_raw.
struct RawCamera {
  int width_px = 0;
  int height_px = 0;
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  std::array<double, 5> distortion{};
  Eigen::Matrix3d R_rect = Eigen::Matrix3d::Identity();

  /// Whether it has no distortion and the orientation of the rectified camera.
  [[nodiscard]] bool is_pinhole() const;
  /// Normalised image coordinates in the rectified camera of a raw pixel.
  [[nodiscard]] Eigen::Vector2d rectified_ray(const Eigen::Vector2d& pixel) const;
  /// Raw pixel of a point given in the rectified camera's frame.
  [[nodiscard]] Eigen::Vector2d project(const Eigen::Vector3d& p_rect) const;
};

/// The rig: rectified geometry, and the cameras that take the pictures.
struct CameraRig {
  StereoGeometry rectified;
  std::array<RawCamera, 2> raw;
  bool distorted = false;
};

/// The same rig with another picture size: the same lens on a finer or coarser sensor, with rows cut or added at the
/// upper and the lower edge. Without a height, the aspect ratio stays.
[[nodiscard]] StereoGeometry resized(const StereoGeometry& rig, std::optional<int> width_px,
                                     std::optional<int> height_px);

/// Cameras that deliver rectified pictures.
[[nodiscard]] CameraRig ideal_rig(const StereoGeometry& rectified);
/// Realistic raw cameras: barrel distortion, axes a degree askew, principal points off centre. Their pictures cover the
/// whole rectified image.
[[nodiscard]] CameraRig distorted_rig(const StereoGeometry& rectified);

/// True pose of a camera: rays (x, y, 1) of the calibrated camera leave along (x + shift.x, y + shift.y, 1).
struct ViewPose {
  Se3 T_scene_view;
  Eigen::Vector2f principal_shift = Eigen::Vector2f::Zero();  ///< In normalised image coordinates.
};

/// Direction of each sample of each pixel: normalised image coordinates in the rectified frame of the camera. Samples
/// of a pixel lie on a rotated grid, so that no two share a row or a column.
class SampleRays {
 public:
  SampleRays(const RawCamera& camera, int samples_per_side);

  [[nodiscard]] int width() const noexcept { return width_; }
  [[nodiscard]] int height() const noexcept { return height_; }
  [[nodiscard]] int samples() const noexcept { return samples_; }
  [[nodiscard]] Eigen::Vector2f at(int x, int y, int sample) const noexcept {
    return {xs(x, y)[sample], ys(x, y)[sample]};
  }
  /// The coordinates of all samples of a pixel.
  [[nodiscard]] const float* xs(int x, int y) const noexcept { return &xs_[x_steps_.index(x, y)]; }
  [[nodiscard]] const float* ys(int x, int y) const noexcept { return &ys_[y_steps_.index(x, y)]; }
  /// The ray through the pixel's centre.
  [[nodiscard]] Eigen::Vector2f centre(int x, int y) const noexcept { return at(x, y, samples_); }
  /// Angle that a pixel subtends at the image centre.
  [[nodiscard]] float pixel_rad() const noexcept { return pixel_rad_; }

 private:
  // Distance in a table from a pixel to its neighbour.
  struct Steps {
    std::size_t column = 0;
    std::size_t row = 0;

    [[nodiscard]] std::size_t index(int x, int y) const noexcept {
      return static_cast<std::size_t>(x) * column + static_cast<std::size_t>(y) * row;
    }
  };

  int width_;
  int height_;
  int samples_;
  float pixel_rad_;
  // For each pixel its samples, then the centre. A pinhole has the same x in all rows and the same y in all columns:
  // its tables fit the cache.
  Steps x_steps_;
  Steps y_steps_;
  std::vector<float> xs_;
  std::vector<float> ys_;
};

}  // namespace kinetrace::simulator

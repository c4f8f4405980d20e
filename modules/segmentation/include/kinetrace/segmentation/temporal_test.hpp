// Test of motion against rest, by the images of the last frames.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/segmentation/cell_disparity.hpp"
#include "kinetrace/segmentation/frame_history.hpp"
#include "kinetrace/segmentation/ground_plane.hpp"

namespace kinetrace::segmentation {

/// Dense data of the newest frame and its history.
struct DenseView {
  const CellDisparity& disparity;
  const GroundPlane& ground;
  const FrameHistory& history;
};

/// Compares the patch around a cell with an earlier image at two places: where the cell was if at rest, and where if it
/// moved with a velocity. The difference of the two residuals is a log-likelihood ratio, in nats.
class TemporalTest {
 public:
  /// The two places in an earlier frame, full pixels.
  struct Places {
    Eigen::Vector2f at_rest{0.F, 0.F};
    Eigen::Vector2f moved{0.F, 0.F};
  };

  /// Valid until the history changes. Velocities are in the axes of the world of the history's poses.
  TemporalTest(const StereoGeometry& geometry, const FrameHistory& history);

  /// `lag` in [1, history.size()).
  [[nodiscard]] Places places(const Eigen::Vector3f& velocity_mps, int lag, float u, float v,
                              float disparity_px) const noexcept;
  /// Lag of the newest earlier image in which the two places are distinguishable; 0 without an earlier image.
  [[nodiscard]] int discriminating_lag(const Eigen::Vector3f& velocity_mps, float u, float v,
                                       float disparity_px) const noexcept;
  /// For one cell; positive: moved. 0 without an image, or if the place lies outside.
  [[nodiscard]] float cell_nats(const Eigen::Vector3f& velocity_mps, int lag, int cx, int cy,
                                float disparity_px) const noexcept;
  /// Mean grey difference of one cell's patch; negative without an image, or if the place lies outside.
  [[nodiscard]] float residual(const Eigen::Vector3f& velocity_mps, int lag, int cx, int cy,
                               float disparity_px) const noexcept;
  /// Adds one cell to the normal equations of a change of velocity: residuals are the grey differences of its pixels,
  /// of standard deviation `noise_grey`.
  void add_equations(const Eigen::Vector3f& velocity_mps, int lag, int cx, int cy, float disparity_px, float noise_grey,
                     Eigen::Matrix3f& information, Eigen::Vector3f& weighted) const noexcept;
  /// Lag of the newest image at least so old, or of the oldest one.
  [[nodiscard]] int lag_after(float seconds) const noexcept;
  [[nodiscard]] float elapsed_s(int lag) const noexcept;
  /// Sum over the cells within `radius_m` of (u, v) and of similar depth, divided by overlap().
  [[nodiscard]] float support_nats(const DenseView& dense, const Eigen::Vector3f& velocity_mps, float u, float v,
                                   float disparity_px, float radius_m) const noexcept;
  /// Area of a patch over that of a cell: the redundancy of neighbouring cells.
  [[nodiscard]] float overlap() const noexcept;

 private:
  struct Step {
    Eigen::Matrix3f rotation;  ///< Of T_then_now.
    Eigen::Vector3f translation;
    Eigen::Matrix3f back;  ///< Elapsed time times the rotation from the world into the earlier camera.
  };

  [[nodiscard]] bool patch(int lag, int cx, int cy, Eigen::Vector2i& corner) const noexcept;

  StereoGeometry geometry_;
  const FrameHistory* history_ = nullptr;
  std::array<Step, FrameHistory::kFrames> steps_;
  int step_px_ = 1;
};

}  // namespace kinetrace::segmentation

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

/// Places in an earlier image of points that move with one velocity.
class PastPlaces {
 public:
  /// Of a point now seen at (u, v); full pixels, far outside the image if it was behind the camera.
  [[nodiscard]] Eigen::Vector2f at(float u, float v, float disparity_px) const noexcept;
  /// Derivative of `place`, the result of at(), by the velocity in world axes, pixels per m/s.
  [[nodiscard]] Eigen::Matrix<float, 2, 3> jacobian(float u, float v, float disparity_px,
                                                    const Eigen::Vector2f& place) const noexcept;
  [[nodiscard]] int lag() const noexcept { return lag_; }

 private:
  friend class TemporalTest;

  int lag_ = 0;
  /// Of (u, v, 1, disparity): the homogeneous place, and how far its depth exceeds the least one.
  Eigen::Matrix4f warp_ = Eigen::Matrix4f::Zero();
  Eigen::Matrix3f by_velocity_ = Eigen::Matrix3f::Zero();  ///< Derivative of the homogeneous place, over disparity.
};

/// Compares the patch around a cell with an earlier image at two places: where the cell was if at rest, and where if it
/// moved with a velocity. The difference of the two residuals is a log-likelihood ratio, in nats.
class TemporalTest {
 public:
  struct Hypotheses {
    PastPlaces at_rest;
    PastPlaces moved;
  };

  /// Valid until the history changes. Velocities are in the axes of the world of the history's poses.
  TemporalTest(const StereoGeometry& geometry, const FrameHistory& history);

  /// `lag` in [1, history.size()); of 0 and of later ones up to FrameHistory::kFrames - 1 the places mean nothing, and
  /// no patch is compared.
  [[nodiscard]] PastPlaces places(const Eigen::Vector3f& velocity_mps, int lag) const noexcept;
  [[nodiscard]] PastPlaces places_at_rest(int lag) const noexcept { return places(Eigen::Vector3f::Zero(), lag); }
  [[nodiscard]] Hypotheses hypotheses(const Eigen::Vector3f& velocity_mps, int lag) const noexcept {
    return {places_at_rest(lag), places(velocity_mps, lag)};
  }
  /// Lag of the newest earlier image in which the two places are distinguishable; 0 without an earlier image.
  [[nodiscard]] int discriminating_lag(const Eigen::Vector3f& velocity_mps, float u, float v,
                                       float disparity_px) const noexcept;
  /// For one cell; positive: moved. 0 without an image, or if the place lies outside.
  [[nodiscard]] float cell_nats(const Hypotheses& hypotheses, int cx, int cy, float disparity_px) const noexcept;
  /// Mean grey difference of one cell's patch; negative without an image, or if the place lies outside.
  [[nodiscard]] float residual(const PastPlaces& places, int cx, int cy, float disparity_px) const noexcept;
  /// Adds one cell to the normal equations of a change of velocity: residuals are the grey differences of its pixels,
  /// of standard deviation `noise_grey`.
  void add_equations(const PastPlaces& places, int cx, int cy, float disparity_px, float noise_grey,
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
  /// Of the patch around a cell, in the newest of the matching images.
  struct Patch {
    Eigen::Vector2i corner;
    Eigen::Vector2f place;  ///< Of the cell in the earlier image, full pixels.
    Eigen::Vector2f shift;  ///< To there, pixels of the matching images.
  };

  /// False without one, or without an image to compare with.
  [[nodiscard]] bool find_patch(const PastPlaces& places, int cx, int cy, float disparity_px,
                                Patch& patch) const noexcept;

  StereoGeometry geometry_;
  const FrameHistory* history_ = nullptr;
  std::array<PastPlaces, FrameHistory::kFrames> at_rest_;  ///< By lag.
  int step_px_ = 1;
};

}  // namespace kinetrace::segmentation

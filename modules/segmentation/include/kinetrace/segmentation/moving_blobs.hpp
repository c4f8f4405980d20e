// Parts of the image that contradict the static world and fit one velocity.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/segmentation/config.hpp"
#include "kinetrace/segmentation/temporal_test.hpp"

namespace kinetrace::segmentation {

/// Adjacent changed cells of the image, and its velocity, filtered over all its frames.
struct MovingBlob {
  Eigen::Vector3f velocity_mps{0.F, 0.F, 0.F};            ///< World axes.
  Eigen::Matrix3f information = Eigen::Matrix3f::Zero();  ///< Of the velocity, from image noise alone.
  float nis_ratio = 1.F;                                  ///< Mean NIS over its expectation.
  float rest = 0.F;                                       ///< Mean grey difference at rest...
  float moved = 0.F;                                      ///< ...and at its velocity; means over frames.
  int frames = 0;
  float seen_s = 0.F;  ///< Since its first frame.
  int cells = 0;
  bool moving = false;  ///< With certainty.

  [[nodiscard]] Eigen::Matrix3f covariance() const;
};

/// Finds objects with too few features: people, and slow ones. A cell has changed if its image does not match an
/// earlier one at the place where it would have been at rest, at its own depth or a neighbour's. Touching changed
/// cells at the same depth make a blob. Its common velocity is first searched for across the line of sight; then a
/// filter refines it from frame to frame in all three directions by least squares over the grey differences of all its
/// pixels (Lucas and Kanade 1981, with the velocity as the warp): growth shows the motion along the line of sight, much
/// sooner than disparity does on a short baseline. A blob moves if its velocity is significant, explains the image much
/// better than rest, and is the same from frame to frame.
class MovingBlobs {
 public:
  static constexpr std::size_t kMaxBlobs = 64;
  /// Least age of the compared image: people move by a few pixels, and the static scene hardly changes.
  static constexpr float kLookBackS = 0.09F;

  MovingBlobs() = default;
  MovingBlobs(const MotionConfig& config, const StereoGeometry& geometry, Arena& arena);

  void reset() noexcept;
  /// `test` uses the history in `dense`. `T_world_cam`: its newest pose. The result lives until the next call.
  std::span<const MovingBlob> find(const DenseView& dense, const TemporalTest& test, const Se3& T_world_cam,
                                   double ego_speed_mps);

  /// Value of cells that match the static world.
  static constexpr std::int16_t kStandsStill = -2;
  /// Blob of each cell of the last call, -1 = none, or kStandsStill.
  [[nodiscard]] ImageView<const std::int16_t> blob_of_cell() const noexcept { return owner_; }

 private:
  struct Cell {
    std::int16_t x = 0;
    std::int16_t y = 0;
    float disparity_px = 0.F;
  };

  void remember(ImageView<const float> disparity_px);
  void find_changed(const DenseView& dense, const TemporalTest& test);
  [[nodiscard]] bool stands_elsewhere(const DenseView& dense, const TemporalTest& test, const PastPlaces& at_rest,
                                      int cx, int cy, float limit) const;
  [[nodiscard]] bool was_hidden(const PastPlaces& at_rest, int cx, int cy, float disparity_px) const;
  void collect(int cx, int cy);
  [[nodiscard]] const MovingBlob* previous_blob(const TemporalTest& test) const;
  void search(const TemporalTest& test, const Eigen::Vector3f& across, MovingBlob& blob) const;
  void refine(const TemporalTest& test, const Eigen::Vector3f& down, MovingBlob& blob) const;
  [[nodiscard]] bool significant(const MovingBlob& blob, const Se3& T_world_cam, double ego_speed_mps) const;
  [[nodiscard]] float mean_residual(const TemporalTest& test, const Eigen::Vector3f& velocity_mps,
                                    std::size_t samples) const;
  [[nodiscard]] Eigen::Matrix3f systematic_covariance(const MovingBlob& blob, const Se3& T_world_cam,
                                                      double ego_speed_mps) const;

  MotionConfig config_;
  StereoGeometry geometry_;
  int lag_ = 0;
  float elapsed_s_ = 0.F;   ///< Since the compared image...
  float interval_s_ = 0.F;  ///< ...and since the last one.
  float noise_ = 0.F;       ///< Median grey difference at rest.
  std::span<float> scratch_;
  std::array<ImageView<float>, FrameHistory::kFrames> past_disparity_;  ///< Of the last frames, as a ring.
  std::size_t newest_ = 0;
  ImageView<float> residual_;  ///< Of each cell, assumed at rest; negative where unknown.
  ImageView<float> changed_;   ///< Disparity of changed cells, else negative.
  ImageView<std::int16_t> owner_;
  ImageView<std::int16_t> owner_before_;
  FixedVector<Cell> cells_;  ///< Of the current blob.
  FixedVector<MovingBlob> blobs_;
  FixedVector<MovingBlob> blobs_before_;
};

}  // namespace kinetrace::segmentation

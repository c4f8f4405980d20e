// Pixel masks of moving regions.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/segmentation/cell_disparity.hpp"
#include "kinetrace/segmentation/frame_history.hpp"
#include "kinetrace/segmentation/ground_plane.hpp"
#include "kinetrace/segmentation/motion_evidence.hpp"
#include "kinetrace/segmentation/motion_memory.hpp"
#include "kinetrace/segmentation/moving_blobs.hpp"
#include "kinetrace/segmentation/temporal_test.hpp"

namespace kinetrace::segmentation {

/// Assigns each cell of 4x4 pixels near a region to it or not, by a log-likelihood ratio: whether its disparity lies
/// within the region's depth, whether it is above the ground, whether the last images match better if it moved with the
/// region than at rest, whether it was the region's before, and whether features nearby agree. The ratios are averaged
/// along surfaces, not across steps of intensity or disparity (a recursive edge-aware filter, Gastal and Oliveira
/// 2011), and a cell is assigned to the region with the largest. The outlines of regions larger than people, which are
/// vehicles, are made convex by cells without texture, or of its depth above the ground: plain parts show no motion.
class RegionMask {
 public:
  RegionMask() = default;
  RegionMask(const StereoGeometry& geometry, int max_features, int max_objects, int min_area_px, Arena& arena);

  void reset() noexcept;
  /// Returns the number of dropped regions: beyond max_objects (the smallest ones) or below min_area_px.
  int draw(std::span<const Feature> features, std::span<const FeatureMotion> motions, MotionMemory& memory,
           const DenseView& dense, const TemporalTest& test, ImageView<const std::int16_t> blob_of_cell);

  /// For each blob: id of the region that at least half of its cells were drawn as in the frame before, or, of a moving
  /// one, beside which it lies and as which it moves; 0 = none. The result lives until the next call.
  std::span<const std::uint32_t> drawn_as(std::span<const MovingBlob> blobs, ImageView<const std::int16_t> blob_of_cell,
                                          const DenseView& dense, const TemporalTest& test);
  /// For each feature: id of the region drawn at its previous place in the previous frame; 0 = none. The result lives
  /// until the next call.
  std::span<const std::uint32_t> drawn_regions(std::span<const Feature> features);

  /// True if the images show that the region, as drawn in the frame before, has continued its motion.
  [[nodiscard]] bool moves_on(const MotionRegion& region, const DenseView& dense, const TemporalTest& test) const;

  /// For each new feature on a tracked body: id of the region drawn in the previous frame at its place then; 0
  /// otherwise. The result lives until the next call.
  std::span<const std::uint32_t> inherited_regions(std::span<const Feature> features);

  [[nodiscard]] LabelView labels() const noexcept { return labels_; }
  /// Largest first; class unknown.
  [[nodiscard]] std::span<const Detection> detections() const noexcept { return detections_.span(); }
  /// Central disparity of each of them.
  [[nodiscard]] std::span<const float> disparities_px() const noexcept { return disparities_px_.span(); }

 private:
  /// A region being drawn.
  struct Candidate {
    std::uint32_t region_id = 0;
    Eigen::Vector3f velocity_mps{0.F, 0.F, 0.F};  ///< World axes; 0 when stopped.
    Eigen::Matrix3f covariance = Eigen::Matrix3f::Zero();
    bool moving = false;
    bool has_blob = false;     ///< Some of its cells belong to a blob.
    float disparity_px = 0.F;  ///< Central value of its features.
    float near_px = 0.F;       ///< Greatest disparity of its own cells...
    float far_px = 0.F;        ///< ...and least one.
    int lag = 1;               ///< Frames back to the compared image.
    PixelBox cells;            ///< Search box.
  };
  /// The region as drawn last; null if it was not.
  [[nodiscard]] const Candidate* drawn(std::uint32_t region_id) const noexcept;
  [[nodiscard]] bool describe(std::size_t region, std::span<const Feature> features, const MotionMemory& memory,
                              const DenseView& dense, const TemporalTest& test, Candidate& candidate);
  /// The region beside a blob if its velocity explains the blob as well as the blob's own; 0 = none.
  [[nodiscard]] std::uint32_t part_of(const MovingBlob& blob, std::int16_t index,
                                      ImageView<const std::int16_t> blob_of_cell, const DenseView& dense,
                                      const TemporalTest& test) const;
  /// The nearest region drawn in the frame before in a cell's row and column, across a gap at most; 0 = none.
  [[nodiscard]] std::uint32_t region_beside(int cx, int cy, float disparity_px) const noexcept;
  /// True if regions `other` (-1 = none) and `region` are vehicles beside each other that were one region.
  [[nodiscard]] static bool is_beside(const MotionMemory& memory, std::int16_t other, std::size_t region);
  /// Gives regions that became parts of others to these, in the frame before.
  void join_cells(std::span<const JoinedRegion> joined);
  /// Gives a region that is drawn for the first time those cells of the frame before that are nearer to its features
  /// than to those of the region beside it, as which they were drawn.
  void take_over_cells(std::size_t region, std::span<const Feature> features, const MotionMemory& memory);
  [[nodiscard]] bool is_member(int cx, int cy, std::size_t region, const MotionMemory& memory) const noexcept;
  void weigh_blobs(const Candidate& candidate, const MotionMemory& memory, std::size_t region);
  void weigh_cells(const Candidate& candidate, std::span<const Feature> features,
                   std::span<const FeatureMotion> motions, const MotionMemory& memory, std::size_t region,
                   const DenseView& dense, const TemporalTest& test);
  void weigh_memory(const Candidate& candidate, const DenseView& dense, const TemporalTest& test);
  void measure_distances(const PixelBox& cells);
  void diffuse(const Candidate& candidate, const DenseView& dense);
  void assign_cells(const Candidate& candidate, std::size_t index);
  /// Gives free cells to the vehicles whose outline they are in.
  void complete_vehicles(std::span<const Feature> features, const DenseView& dense) noexcept;
  void complete_vehicle(std::int16_t index, const DenseView& dense) noexcept;
  /// first_column_, last_column_ <- those of the candidate's cells; returns their box.
  [[nodiscard]] PixelBox find_rows(std::int16_t index) noexcept;
  void write_labels();

  StereoGeometry geometry_;
  int min_area_px_ = 0;
  MutableLabelView labels_;
  FixedVector<Detection> detections_;
  FixedVector<float> disparities_px_;  ///< Of the detections.
  FixedVector<Candidate> candidates_;
  FixedVector<Candidate> drawn_;  ///< Of the frame before.
  std::array<std::uint32_t, kMaxObjects + 1> region_of_label_{};
  FixedVector<std::uint32_t> inherited_;
  FixedVector<std::uint32_t> drawn_region_;
  FixedVector<std::uint32_t> drawn_as_;
  ImageView<const std::int16_t> blob_of_cell_;  ///< Of the frame being drawn.
  std::span<float> scratch_;
  ImageView<std::uint32_t> previous_;  ///< Region drawn on each cell in the frame before.
  /// Candidate of each cell, plus kCompleted where it has the cell by its outline alone; kFree or kClosed: none.
  ImageView<std::int16_t> owner_;
  static constexpr std::int16_t kCompleted = MotionMemory::kMaxRegions;
  static constexpr std::int16_t kFree = -1;
  static constexpr std::int16_t kClosed = -2;  ///< Given to none.
  ImageView<float> best_;                      ///< Log-likelihood ratio of that candidate.
  ImageView<float> evidence_;                  ///< Log-likelihood ratios of the candidate being drawn.
  ImageView<float> posterior_;                 ///< Log-likelihood ratio of the region in previous_.
  ImageView<float> distance_;                  ///< To its nearest member, in cells.
  ImageView<float> grey_;                      ///< Mean of each cell.
  ImageView<float> weight_right_;              ///< Of the edge-aware filter, towards the next column...
  ImageView<float> weight_down_;               ///< ...and row.
  std::span<std::uint32_t> stack_;
  std::span<float> first_column_;  ///< By row of cells, of a candidate; kNoColumn: none.
  std::span<float> last_column_;   ///< Negated.
};

}  // namespace kinetrace::segmentation

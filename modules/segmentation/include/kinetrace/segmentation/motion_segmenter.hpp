// Independently moving regions, without a network, from the residual of the ego motion.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "kinetrace/segmentation/cell_disparity.hpp"
#include "kinetrace/segmentation/frame_history.hpp"
#include "kinetrace/segmentation/ground_plane.hpp"
#include "kinetrace/segmentation/motion_clusters.hpp"
#include "kinetrace/segmentation/motion_evidence.hpp"
#include "kinetrace/segmentation/motion_memory.hpp"
#include "kinetrace/segmentation/moving_blobs.hpp"
#include "kinetrace/segmentation/region_mask.hpp"
#include "kinetrace/segmentation/segmenter.hpp"

namespace kinetrace::segmentation {

/// Features -> velocities (MotionEvidence) -> clusters (MotionClusters) -> accepted regions (MotionMemory) -> masks
/// (RegionMask). Left masks only; the class is unknown. A frame without ego motion has no detections available and
/// clears all evidence, because earlier frames can no longer be related to later ones.
class MotionSegmenter final : public Segmenter {
 public:
  [[nodiscard]] static std::size_t required_bytes(const SegmentationConfig& config, const StereoGeometry& geometry,
                                                  int max_features);
  /// Errors: kInvalidConfig, kCapacity.
  [[nodiscard]] static Result<std::unique_ptr<MotionSegmenter>> create(const SegmentationConfig& config,
                                                                       const StereoGeometry& geometry, int max_features,
                                                                       Arena& arena);

  [[nodiscard]] Result<DetectionFrame> process(const SegmentationInput& input) override;
  void reset() override;

  /// Central disparity of each detection of the last frame.
  [[nodiscard]] std::span<const float> disparities_px() const noexcept { return mask_.disparities_px(); }

 private:
  MotionSegmenter() = default;
  static void carve(const SegmentationConfig& config, const StereoGeometry& geometry, int max_features, Arena& arena,
                    MotionSegmenter& segmenter);

  void look(const SegmentationInput& input, std::span<const FeatureMotion> motions);

  /// Blob under each feature, -1 = none.
  std::span<const std::int16_t> blobs_of(std::span<const Feature> features);

  StereoGeometry geometry_;
  bool started_ = false;
  std::int64_t timestamp_ns_ = 0;  ///< Of the last frame.
  MotionEvidence evidence_;
  MotionClusters clusters_;
  MotionMemory memory_;
  FrameHistory history_;
  MutableGrayView right_;  ///< Right image at matching size.
  CellDisparity disparity_;
  GroundPlane ground_;
  MovingBlobs blobs_;
  FixedVector<std::int16_t> blob_of_feature_;
  std::span<float> scratch_;
  std::uint32_t frames_ = 0;
  RegionMask mask_;
};

}  // namespace kinetrace::segmentation

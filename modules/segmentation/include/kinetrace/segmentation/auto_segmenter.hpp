// Motion segmentation and a neural network together.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/segmentation/mask_fusion.hpp"
#include "kinetrace/segmentation/motion_segmenter.hpp"
#include "kinetrace/segmentation/network_segmenter.hpp"
#include "kinetrace/segmentation/segmenter.hpp"

namespace kinetrace::segmentation {

/// Runs both on each frame, at the same time if there are workers, and fuses their masks (MaskFusion). A frame without
/// masks of the network, because it is slow, fails or hangs, reports moving regions alone, with
/// DetectionFrame::moving_only. A frame without ego motion reports the network's masks alone. Frames without the
/// network's masks count as missing.
class AutoSegmenter final : public Segmenter {
 public:
  [[nodiscard]] static std::size_t required_bytes(const SegmentationConfig& config, const StereoGeometry& geometry,
                                                  int max_features);
  /// Errors: kInvalidConfig (also without a source), kCapacity.
  [[nodiscard]] static Result<std::unique_ptr<AutoSegmenter>> create(const SegmentationConfig& config,
                                                                     const StereoGeometry& geometry, int max_features,
                                                                     Arena& arena, DelayedMaskSource* network,
                                                                     Workers* workers = nullptr);

  void load(const RectifiedPair& pair, std::span<const Track> tracks) override;
  /// Errors: kIllegalState if load() was not called for this frame.
  [[nodiscard]] Result<DetectionFrame> process(const SegmentationInput& input) override;
  void reset() override;

 private:
  AutoSegmenter() = default;
  static void carve(const SegmentationConfig& config, const StereoGeometry& geometry, Arena& arena,
                    AutoSegmenter& segmenter);
  [[nodiscard]] DetectionFrame weigh(const DetectionFrame& seen, const DetectionFrame& moving) noexcept;

  Workers* workers_ = nullptr;
  std::unique_ptr<MotionSegmenter> motion_;
  std::unique_ptr<NetworkSegmenter> network_;
  MaskFusion left_;
  MaskFusion right_;  ///< Without memory if the right image is not segmented.
};

}  // namespace kinetrace::segmentation

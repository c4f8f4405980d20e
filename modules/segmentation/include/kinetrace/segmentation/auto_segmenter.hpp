// Motion and a neural network together.
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

/// Looks at each frame with both, and makes one set of masks of what they say (MaskFusion). In a frame that no masks of
/// the network have come for, because it is slow, fails or hangs, moving regions alone are reported, and said to be
/// just that: DetectionFrame::moving_only. A frame without ego motion has what the network says. Missing frames are
/// those of the network.
class AutoSegmenter final : public Segmenter {
 public:
  [[nodiscard]] static std::size_t required_bytes(const SegmentationConfig& config, const StereoGeometry& geometry,
                                                  int max_features);
  /// Errors: kInvalidConfig (also without a source), kCapacity.
  [[nodiscard]] static Result<std::unique_ptr<AutoSegmenter>> create(const SegmentationConfig& config,
                                                                     const StereoGeometry& geometry, int max_features,
                                                                     Arena& arena, DelayedMaskSource* network);

  void load(const RectifiedPair& pair, std::span<const Track> tracks) override;
  /// Errors: kIllegalState if load() was not called for this frame.
  [[nodiscard]] Result<DetectionFrame> process(const SegmentationInput& input) override;
  void reset() override;

 private:
  AutoSegmenter() = default;
  static void carve(const SegmentationConfig& config, const StereoGeometry& geometry, Arena& arena,
                    AutoSegmenter& segmenter);
  [[nodiscard]] DetectionFrame weigh(const DetectionFrame& seen, const DetectionFrame& moving) noexcept;

  std::unique_ptr<MotionSegmenter> motion_;
  std::unique_ptr<NetworkSegmenter> network_;
  MaskFusion left_;
  MaskFusion right_;  ///< Without memory where the right image is not looked at.
};

}  // namespace kinetrace::segmentation

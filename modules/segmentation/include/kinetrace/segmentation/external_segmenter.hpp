// Instance masks from another process.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/segmentation/instance_image.hpp"
#include "kinetrace/segmentation/mask_canvas.hpp"
#include "kinetrace/segmentation/segmenter.hpp"

namespace kinetrace::segmentation {

/// Requests the masks of each frame from a MaskSource at its arrival, and fetches them when needed: the other process
/// works in parallel with image pyramid, features and ego motion. A frame whose masks are late counts as missing and
/// has no detections.
class ExternalSegmenter final : public Segmenter {
 public:
  [[nodiscard]] static std::size_t required_bytes(const SegmentationConfig& config, const StereoGeometry& geometry);
  /// Errors: kInvalidConfig (also without a source), kCapacity.
  [[nodiscard]] static Result<std::unique_ptr<ExternalSegmenter>> create(const SegmentationConfig& config,
                                                                         const StereoGeometry& geometry, Arena& arena,
                                                                         MaskSource* masks);

  /// Requests the masks of this frame; does not wait.
  void load(const RectifiedPair& pair, std::span<const Track> tracks) override;
  /// Waits for the masks. Errors: kIllegalState if load() was not called for this frame.
  [[nodiscard]] Result<DetectionFrame> process(const SegmentationInput& input) override;
  void reset() override { loaded_ = false; }

 private:
  ExternalSegmenter() = default;
  static void carve(const SegmentationConfig& config, const StereoGeometry& geometry, Arena& arena,
                    ExternalSegmenter& segmenter);
  void draw(std::span<const RunLengthMask> masks, MaskCanvas& canvas) noexcept;

  SegmentationConfig config_;
  MaskSource* masks_ = nullptr;
  MaskCanvas left_;
  MaskCanvas right_;  ///< Without memory if masks of the right image are not requested.
  InstanceRelabeler relabeler_;
  bool loaded_ = false;
  std::int64_t loaded_frame_index_ = 0;
};

}  // namespace kinetrace::segmentation

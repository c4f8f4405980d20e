// Instance masks that another process makes.
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

/// Asks a MaskSource for the masks of each frame when the frame comes, and takes them when they are needed: what lies
/// between (image pyramid, features, ego motion) is time that the other process has anyway. A frame whose masks did not
/// come in time is counted as missing and has no detections.
class ExternalSegmenter final : public Segmenter {
 public:
  [[nodiscard]] static std::size_t required_bytes(const SegmentationConfig& config, const StereoGeometry& geometry);
  /// Errors: kInvalidConfig (also without a source), kCapacity.
  [[nodiscard]] static Result<std::unique_ptr<ExternalSegmenter>> create(const SegmentationConfig& config,
                                                                         const StereoGeometry& geometry, Arena& arena,
                                                                         MaskSource* masks);

  /// Asks for the masks of this frame; does not wait.
  void load(const RectifiedPair& pair, std::span<const Track> tracks) override;
  /// Waits for them. Errors: kIllegalState if load() was not called for this frame.
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
  MaskCanvas right_;  ///< Without memory where nobody asks for masks of the right image.
  InstanceRelabeler relabeler_;
  bool loaded_ = false;
  std::int64_t loaded_frame_index_ = 0;
};

}  // namespace kinetrace::segmentation

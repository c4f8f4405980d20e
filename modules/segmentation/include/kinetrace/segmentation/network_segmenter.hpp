// Instance masks of a neural network that is slower than the camera.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/segmentation/instance_image.hpp"
#include "kinetrace/segmentation/mask_canvas.hpp"
#include "kinetrace/segmentation/mask_warp.hpp"
#include "kinetrace/segmentation/region_chooser.hpp"
#include "kinetrace/segmentation/segmenter.hpp"

namespace kinetrace::segmentation {

/// Hands frame k over when it comes, goes on with the frames after it, takes its masks at frame k + latency_frames (or
/// as soon after it as they are there), warps them to the present, and hands the next frame over. Frames in between
/// have no detections: tracks are propagated. After each whole image it hands over `regions` parts around tracks, if
/// there are tracks that fit into one.
class NetworkSegmenter final : public Segmenter {
 public:
  [[nodiscard]] static std::size_t required_bytes(const SegmentationConfig& config, const StereoGeometry& geometry,
                                                  int max_features);
  /// Errors: kInvalidConfig (also without a source), kCapacity.
  [[nodiscard]] static Result<std::unique_ptr<NetworkSegmenter>> create(const SegmentationConfig& config,
                                                                        const StereoGeometry& geometry,
                                                                        int max_features, Arena& arena,
                                                                        DelayedMaskSource* network);

  void load(const RectifiedPair& pair, std::span<const Track> tracks) override;
  /// Errors: kIllegalState if load() was not called for this frame.
  [[nodiscard]] Result<DetectionFrame> process(const SegmentationInput& input) override;
  /// What the network still works on is not used.
  void reset() override;

 private:
  struct UnderWay {
    PixelBox region_px;  ///< Empty: the whole image, and the right one too if it is looked at.
    int age_frames = 0;
    bool is_wanted = true;  ///< False after reset() or a jump.
  };

  NetworkSegmenter() = default;
  static void carve(const SegmentationConfig& config, const StereoGeometry& geometry, int max_features, Arena& arena,
                    NetworkSegmenter& segmenter);
  [[nodiscard]] PixelBox next_region(std::span<const Track> tracks) noexcept;
  /// Asks the network whether it is done; what it says is kept for process().
  void collect() noexcept;
  /// Masks of the present frame alone are still wanted.
  void forget_earlier_frames() noexcept;
  void deliver(const SegmentationInput& input, DetectionFrame& frame) noexcept;

  SegmentationConfig config_;
  DelayedMaskSource* network_ = nullptr;
  MaskCanvas left_;
  MaskCanvas right_;  ///< Without memory where the right image is not looked at.
  MaskWarp warp_;
  InstanceRelabeler relabeler_;
  std::optional<UnderWay> under_way_;
  RegionChooser chooser_;
  int regions_left_ = 0;  ///< Until the next whole image.
  const MaskSet* collected_ = nullptr;
  UnderWay collected_as_;
  bool is_due_ = false;  ///< Masks were to come with this frame.
  std::optional<std::int64_t> loaded_frame_index_;
};

}  // namespace kinetrace::segmentation

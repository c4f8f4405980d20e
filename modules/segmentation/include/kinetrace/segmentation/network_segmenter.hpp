// Instance masks from a neural network that is slower than the camera.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/segmentation/candidate_filter.hpp"
#include "kinetrace/segmentation/instance_image.hpp"
#include "kinetrace/segmentation/mask_canvas.hpp"
#include "kinetrace/segmentation/mask_warp.hpp"
#include "kinetrace/segmentation/region_chooser.hpp"
#include "kinetrace/segmentation/segmenter.hpp"

namespace kinetrace::segmentation {

/// Submits frame k at its arrival, fetches its masks at frame k + latency_frames (or as soon after it as they are
/// ready), warps them to the present, and submits the next frame. Frames in between have no detections: tracks are
/// propagated. After each whole image it submits `regions` parts around tracks, as far as tracks fit into one.
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
  /// The result of a frame in progress is discarded.
  void reset() override;

 private:
  struct UnderWay {
    PixelBox region_px;  ///< Empty: the whole image, and the right one, if it is segmented.
    int age_frames = 0;
    bool is_wanted = true;  ///< False after reset() or a cut.
  };

  NetworkSegmenter() = default;
  static void carve(const SegmentationConfig& config, const StereoGeometry& geometry, int max_features, Arena& arena,
                    NetworkSegmenter& segmenter);
  [[nodiscard]] PixelBox next_region(std::span<const Track> tracks) noexcept;
  /// Polls the network; the result is kept for process().
  void collect() noexcept;
  /// Only masks of the present frame are still wanted.
  void forget_earlier_frames() noexcept;
  void deliver(const SegmentationInput& input, DetectionFrame& frame) noexcept;

  SegmentationConfig config_;
  DelayedMaskSource* network_ = nullptr;
  MaskCanvas left_;
  MaskCanvas right_;  ///< Without memory if the right image is not segmented.
  SeenFeatures seen_;
  CandidateFilter filter_;
  MaskWarp warp_;
  InstanceRelabeler relabeler_;
  std::optional<UnderWay> under_way_;
  RegionChooser chooser_;
  int regions_left_ = 0;  ///< Until the next whole image.
  const MaskSet* collected_ = nullptr;
  UnderWay collected_as_;
  bool is_due_ = false;  ///< Masks were expected with this frame.
  std::optional<std::int64_t> loaded_frame_index_;
};

}  // namespace kinetrace::segmentation

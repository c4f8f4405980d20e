#include "kinetrace/segmentation/external_segmenter.hpp"

#include <string>

namespace kinetrace::segmentation {
void ExternalSegmenter::carve(const SegmentationConfig& config, const StereoGeometry& geometry, Arena& arena,
                              ExternalSegmenter& segmenter) {
  segmenter.left_ = MaskCanvas(geometry, config.max_objects, arena);
  if (config.dds.right) {
    segmenter.right_ = MaskCanvas(geometry, config.max_objects, arena);
  }
  segmenter.relabeler_ = InstanceRelabeler(arena);
}

std::size_t ExternalSegmenter::required_bytes(const SegmentationConfig& config, const StereoGeometry& geometry) {
  return measure_bytes([&](Arena& arena) {
    ExternalSegmenter segmenter;
    carve(config, geometry, arena, segmenter);
  });
}

Result<std::unique_ptr<ExternalSegmenter>> ExternalSegmenter::create(const SegmentationConfig& config,
                                                                     const StereoGeometry& geometry, Arena& arena,
                                                                     MaskSource* masks) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  if (masks == nullptr) {
    return fail(ErrorCode::kInvalidConfig,
                "segmentation.mode dds: masks are not received here; only `kinetrace run --publish` does");
  }
  std::unique_ptr<ExternalSegmenter> segmenter(new ExternalSegmenter());
  segmenter->config_ = config;
  segmenter->masks_ = masks;
  carve(config, geometry, arena, *segmenter);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "segmentation: the arena does not hold " +
                                          std::to_string(required_bytes(config, geometry)) +
                                          " bytes; size it with segmentation::required_bytes");
  }
  return segmenter;
}

void ExternalSegmenter::load(const RectifiedPair& pair, std::span<const Track> /*tracks*/) {
  masks_->request(pair);
  loaded_ = true;
  loaded_frame_index_ = pair.frame_index;
}

Result<DetectionFrame> ExternalSegmenter::process(const SegmentationInput& input) {
  if (!loaded_ || loaded_frame_index_ != input.pair.frame_index) {
    return fail(ErrorCode::kIllegalState,
                "segmentation: load() was not called for frame " + std::to_string(input.pair.frame_index));
  }
  ++counters_.frames;
  DetectionFrame frame;
  const MaskSet* masks = masks_->await(input.pair.frame_index);
  if (masks == nullptr) {
    ++counters_.frames_missing;
    return frame;
  }
  draw(masks->left, left_);
  frame.available = true;
  frame.left_labels = left_.labels();
  frame.left = left_.detections();
  counters_.detections += frame.left.size();
  if (config_.dds.right) {
    draw(masks->right, right_);
    frame.right_labels = right_.labels();
    frame.right = right_.detections();
  }
  return frame;
}

void ExternalSegmenter::draw(std::span<const RunLengthMask> masks, MaskCanvas& canvas) noexcept {
  canvas.draw(masks);
  counters_.detections_dropped += static_cast<std::uint64_t>(canvas.finish(config_, relabeler_));
}

}  // namespace kinetrace::segmentation

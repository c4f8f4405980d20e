#include "kinetrace/segmentation/external_segmenter.hpp"

#include <algorithm>
#include <string>

namespace kinetrace::segmentation {
namespace {

/// Gives the pixels of a mask that no other has yet the value.
void paint(const RunLengthMask& mask, std::uint16_t value, ImageView<std::uint16_t> image) noexcept {
  const auto width = static_cast<std::size_t>(mask.box_px.width());
  std::size_t at = 0;  // In the box, row by row.
  bool inside = false;
  for (const std::uint16_t run : mask.runs) {
    const std::size_t end = at + run;
    while (inside && at < end) {
      const std::size_t row_end = std::min(end, (at / width + 1) * width);
      std::uint16_t* row = image.row(mask.box_px.y0 + static_cast<int>(at / width)) + mask.box_px.x0;
      std::replace(row + at % width, row + at % width + (row_end - at), std::uint16_t{kBackgroundLabel}, value);
      at = row_end;
    }
    at = end;
    inside = !inside;
  }
}

}  // namespace

void ExternalSegmenter::carve(const SegmentationConfig& config, const StereoGeometry& geometry, Arena& arena,
                              ExternalSegmenter& segmenter) {
  for (EyeImages* eye : {&segmenter.left_, &segmenter.right_}) {
    if (eye == &segmenter.right_ && !config.dds.right) {
      continue;
    }
    eye->values = take_image<std::uint16_t>(arena, geometry.width_px, geometry.height_px);
    eye->labels = take_image<std::uint8_t>(arena, geometry.width_px, geometry.height_px);
    eye->detections = FixedVector<Detection>(arena, static_cast<std::size_t>(config.max_objects));
  }
  segmenter.listed_ = FixedVector<ListedInstance>(arena, kMaxMasks);
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
                "segmentation.mode dds: nobody receives masks here; only `kinetrace run --publish` does");
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

void ExternalSegmenter::load(const RectifiedPair& pair) {
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
  frame.left_labels = left_.labels;
  frame.left = left_.detections.span();
  counters_.detections += left_.detections.size();
  if (config_.dds.right) {
    draw(masks->right, right_);
    frame.right_labels = right_.labels;
    frame.right = right_.detections.span();
  }
  return frame;
}

void ExternalSegmenter::draw(std::span<const RunLengthMask> masks, EyeImages& eye) noexcept {
  for (int y = 0; y < eye.values.height; ++y) {
    std::fill_n(eye.values.row(y), eye.values.width, std::uint16_t{kBackgroundLabel});
  }
  listed_.clear();
  for (const RunLengthMask& mask : masks.first(std::min(masks.size(), listed_.capacity()))) {
    static_cast<void>(listed_.push_back({mask.class_id, mask.score}));
    paint(mask, static_cast<std::uint16_t>(listed_.size()), eye.values);
  }
  const int dropped = relabeler_.relabel(eye.values, MaskEncoding::kListed, config_.max_objects, config_.min_area_px,
                                         eye.labels, eye.detections, listed_.span());
  counters_.detections_dropped += static_cast<std::uint64_t>(dropped) + masks.size() - listed_.size();
}

}  // namespace kinetrace::segmentation

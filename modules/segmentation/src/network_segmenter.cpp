#include "kinetrace/segmentation/network_segmenter.hpp"

#include <string>

namespace kinetrace::segmentation {

void NetworkSegmenter::carve(const SegmentationConfig& config, const StereoGeometry& geometry, int max_features,
                             Arena& arena, NetworkSegmenter& segmenter) {
  segmenter.left_ = MaskCanvas(geometry, config.max_objects, arena);
  if (config.onnx.right) {
    segmenter.right_ = MaskCanvas(geometry, config.max_objects, arena);
  }
  segmenter.seen_ = SeenFeatures(max_features, arena);
  segmenter.filter_ = CandidateFilter(geometry, max_features, arena);
  segmenter.warp_ = MaskWarp(geometry, max_features, config.onnx.right, arena);
  segmenter.relabeler_ = InstanceRelabeler(arena);
}

std::size_t NetworkSegmenter::required_bytes(const SegmentationConfig& config, const StereoGeometry& geometry,
                                             int max_features) {
  return measure_bytes([&](Arena& arena) {
    NetworkSegmenter segmenter;
    carve(config, geometry, max_features, arena, segmenter);
  });
}

Result<std::unique_ptr<NetworkSegmenter>> NetworkSegmenter::create(const SegmentationConfig& config,
                                                                   const StereoGeometry& geometry, int max_features,
                                                                   Arena& arena, DelayedMaskSource* network) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  if (network == nullptr) {
    return fail(ErrorCode::kInvalidConfig, "segmentation.mode onnx: there is no network; give Pipeline::create one");
  }
  std::unique_ptr<NetworkSegmenter> segmenter(new NetworkSegmenter());
  segmenter->config_ = config;
  segmenter->network_ = network;
  segmenter->chooser_ = RegionChooser(geometry);
  carve(config, geometry, max_features, arena, *segmenter);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "segmentation: the arena does not hold " +
                                          std::to_string(required_bytes(config, geometry, max_features)) +
                                          " bytes; size it with segmentation::required_bytes");
  }
  return segmenter;
}

void NetworkSegmenter::load(const RectifiedPair& pair, std::span<const Track> tracks) {
  loaded_frame_index_ = pair.frame_index;
  collected_ = nullptr;
  if (under_way_) {
    ++under_way_->age_frames;
  }
  is_due_ = !under_way_ ? config_.onnx.latency_frames == 0 : under_way_->age_frames >= config_.onnx.latency_frames;
  if (under_way_) {
    collect();
  }
  if (!under_way_) {
    under_way_.emplace(UnderWay{.region_px = next_region(tracks)});
    network_->offer(pair, under_way_->region_px);
  }
}

PixelBox NetworkSegmenter::next_region(std::span<const Track> tracks) noexcept {
  const PixelBox region_px = regions_left_ > 0 ? chooser_.choose(tracks) : PixelBox{};
  regions_left_ = region_px.empty() ? config_.onnx.regions : regions_left_ - 1;
  return region_px;
}

void NetworkSegmenter::collect() noexcept {
  if (under_way_->is_wanted && under_way_->age_frames < config_.onnx.latency_frames) {
    return;
  }
  const DelayedMasks result = network_->take();
  if (!result.done) {
    return;
  }
  if (under_way_->is_wanted) {
    collected_ = result.masks;
    collected_as_ = *under_way_;
  }
  under_way_.reset();
}

Result<DetectionFrame> NetworkSegmenter::process(const SegmentationInput& input) {
  if (loaded_frame_index_ != input.pair.frame_index) {
    return fail(ErrorCode::kIllegalState,
                "segmentation: load() was not called for frame " + std::to_string(input.pair.frame_index));
  }
  ++counters_.frames;
  if (input.is_cut) {
    forget_earlier_frames();
  }
  DetectionFrame frame;
  if (under_way_ && under_way_->age_frames == 0 && config_.onnx.latency_frames == 0) {
    collect();
  }
  if (collected_ != nullptr) {
    if (collected_as_.age_frames == 0) {
      seen_.remember(input.features);
    }
    deliver(input, frame);
  }
  counters_.frames_missing += is_due_ && !frame.available ? 1 : 0;
  // Only after warping the masks of the frame before.
  if (under_way_ && under_way_->age_frames == 0) {
    warp_.remember(input.pair);
    seen_.remember(input.features);
  }
  return frame;
}

void NetworkSegmenter::forget_earlier_frames() noexcept {
  if (collected_ != nullptr && collected_as_.age_frames > 0) {
    collected_ = nullptr;
  }
  if (under_way_ && under_way_->age_frames > 0) {
    under_way_->is_wanted = false;
  }
}

void NetworkSegmenter::deliver(const SegmentationInput& input, DetectionFrame& frame) noexcept {
  const auto draw = [&](std::span<const RunLengthMask> masks, View view, MaskCanvas& canvas) {
    canvas.draw_candidates(masks);
    if (collected_as_.age_frames > 0) {
      warp_.warp(seen_.by_slot(), input, view, canvas);
    }
    counters_.detections_dropped += static_cast<std::uint64_t>(canvas.finish(config_, relabeler_));
  };
  draw(filter_.plausible(collected_->left, seen_.by_slot()), View::kLeft, left_);
  frame.available = true;
  frame.searched_px = collected_as_.region_px;
  frame.left_labels = left_.labels();
  frame.left = left_.detections();
  counters_.detections += frame.left.size();
  if (config_.onnx.right && frame.searched_px.empty()) {
    draw(collected_->right, View::kRight, right_);
    frame.right_labels = right_.labels();
    frame.right = right_.detections();
  }
}

void NetworkSegmenter::reset() {
  loaded_frame_index_.reset();
  collected_ = nullptr;
  chooser_.reset();
  regions_left_ = 0;
  if (under_way_) {
    under_way_->is_wanted = false;
  }
}

}  // namespace kinetrace::segmentation

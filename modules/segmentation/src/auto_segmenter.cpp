#include "kinetrace/segmentation/auto_segmenter.hpp"

#include <array>
#include <string>
#include <utility>

namespace kinetrace::segmentation {
namespace {

/// No candidate is dropped before fusion.
SegmentationConfig network_config(SegmentationConfig config) {
  config.max_objects = kMaxObjects;
  return config;
}

}  // namespace

void AutoSegmenter::carve(const SegmentationConfig& config, const StereoGeometry& geometry, Arena& arena,
                          AutoSegmenter& segmenter) {
  segmenter.left_ = MaskFusion(geometry, config.max_objects, config.min_area_px, arena);
  if (config.onnx.right) {
    segmenter.right_ = MaskFusion(geometry, config.max_objects, config.min_area_px, arena);
  }
}

std::size_t AutoSegmenter::required_bytes(const SegmentationConfig& config, const StereoGeometry& geometry,
                                          int max_features) {
  const auto aligned = [](std::size_t bytes) {
    return (bytes + Arena::kAlignment - 1) / Arena::kAlignment * Arena::kAlignment;
  };
  const std::size_t own_bytes = measure_bytes([&](Arena& arena) {
    AutoSegmenter segmenter;
    carve(config, geometry, arena, segmenter);
  });
  return aligned(MotionSegmenter::required_bytes(config, geometry, max_features)) +
         aligned(NetworkSegmenter::required_bytes(network_config(config), geometry, max_features)) + own_bytes;
}

Result<std::unique_ptr<AutoSegmenter>> AutoSegmenter::create(const SegmentationConfig& config,
                                                             const StereoGeometry& geometry, int max_features,
                                                             Arena& arena, DelayedMaskSource* network,
                                                             Workers* workers) {
  auto motion = MotionSegmenter::create(config, geometry, max_features, arena);
  if (!motion) {
    return Unexpected(motion.error());
  }
  auto seen = NetworkSegmenter::create(network_config(config), geometry, max_features, arena, network);
  if (!seen) {
    return Unexpected(seen.error());
  }
  std::unique_ptr<AutoSegmenter> segmenter(new AutoSegmenter());
  segmenter->workers_ = workers;
  segmenter->motion_ = std::move(*motion);
  segmenter->network_ = std::move(*seen);
  carve(config, geometry, arena, *segmenter);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "segmentation: the arena does not hold " +
                                          std::to_string(required_bytes(config, geometry, max_features)) +
                                          " bytes; size it with segmentation::required_bytes");
  }
  return segmenter;
}

void AutoSegmenter::load(const RectifiedPair& pair, std::span<const Track> tracks) {
  network_->load(pair, tracks);
}

Result<DetectionFrame> AutoSegmenter::process(const SegmentationInput& input) {
  const std::array<Segmenter*, 2> parts{motion_.get(), network_.get()};  // the one that takes longer is begun first
  std::array<Result<DetectionFrame>, 2> found{DetectionFrame{}, DetectionFrame{}};
  in_pieces(workers_, parts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      found[i] = parts[i]->process(input);
    }
  });
  auto& [moving, seen] = found;
  if (!seen) {
    return seen;
  }
  if (!moving) {
    return moving;
  }
  ++counters_.frames;
  counters_.frames_missing = network_->counters().frames_missing;
  return seen->available || moving->available ? weigh(*seen, *moving) : DetectionFrame{};
}

DetectionFrame AutoSegmenter::weigh(const DetectionFrame& seen, const DetectionFrame& moving) noexcept {
  const int dropped =
      left_.fuse({seen.left_labels, seen.left}, {moving.left_labels, moving.left, motion_->disparities_px()});
  counters_.detections += left_.detections().size();
  DetectionFrame frame;
  frame.available = true;
  frame.moving_only = !seen.available;
  frame.searched_px = seen.searched_px;
  frame.left_labels = left_.labels();
  frame.left = left_.detections();
  counters_.detections_dropped += static_cast<std::uint64_t>(dropped);
  if (!seen.right_labels.empty()) {
    // Motion segmentation has left masks only.
    counters_.detections_dropped += static_cast<std::uint64_t>(right_.fuse({seen.right_labels, seen.right}, {}));
    frame.right_labels = right_.labels();
    frame.right = right_.detections();
  }
  return frame;
}

void AutoSegmenter::reset() {
  motion_->reset();
  network_->reset();
}

}  // namespace kinetrace::segmentation

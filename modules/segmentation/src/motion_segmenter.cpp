#include "kinetrace/segmentation/motion_segmenter.hpp"

#include <string>

#include "kinetrace/core/config_check.hpp"

namespace kinetrace::segmentation {

void MotionSegmenter::carve(const SegmentationConfig& config, const StereoGeometry& geometry, int max_features,
                            Arena& arena, MotionSegmenter& segmenter) {
  segmenter.evidence_ = MotionEvidence(config.motion, geometry, max_features, arena);
  segmenter.clusters_ = MotionClusters(config.motion, geometry, max_features, arena);
  segmenter.memory_ = MotionMemory(config.motion, max_features, arena);
  segmenter.mask_ = RegionMask(geometry, max_features, config.max_objects, config.min_area_px, arena);
}

std::size_t MotionSegmenter::required_bytes(const SegmentationConfig& config, const StereoGeometry& geometry,
                                            int max_features) {
  return measure_bytes([&](Arena& arena) {
    MotionSegmenter segmenter;
    carve(config, geometry, max_features, arena, segmenter);
  });
}

Result<std::unique_ptr<MotionSegmenter>> MotionSegmenter::create(const SegmentationConfig& config,
                                                                 const StereoGeometry& geometry, int max_features,
                                                                 Arena& arena) {
  if (const Status valid =
          first_failure({config.validate(), check_range("features.max_features", max_features, 1, 32767)});
      !valid) {
    return Unexpected(valid.error());
  }
  std::unique_ptr<MotionSegmenter> segmenter(new MotionSegmenter());
  carve(config, geometry, max_features, arena, *segmenter);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "segmentation: the arena does not hold " +
                                          std::to_string(required_bytes(config, geometry, max_features)) +
                                          " bytes; size it with segmentation::required_bytes");
  }
  return segmenter;
}

void MotionSegmenter::reset() {
  started_ = false;
  evidence_.reset();
  memory_.reset();
}

Result<DetectionFrame> MotionSegmenter::process(const SegmentationInput& input) {
  ++counters_.frames;
  if (!input.ego_valid) {
    ++counters_.frames_missing;
    if (started_) {
      reset();
    }
  }
  const std::int64_t interval_ns = started_ ? input.pair.timestamp_ns - timestamp_ns_ : kUsualInterval_ns;
  timestamp_ns_ = input.pair.timestamp_ns;
  started_ = true;
  const std::span<const FeatureMotion> motions =
      evidence_.update(input.features, input.pair.left, input.T_prev_cam, input.pair.timestamp_ns);
  if (!input.ego_valid) {
    return DetectionFrame{};
  }
  const std::span<const MotionCluster> clusters = clusters_.find(input.features, motions, evidence_.ego_speed_mps());
  memory_.update(interval_ns, input.features, motions, clusters, clusters_.cluster_of_feature(),
                 mask_.inherited_regions(input.features));
  counters_.detections_dropped += static_cast<std::uint64_t>(mask_.draw(input.features, motions, memory_));
  counters_.detections += mask_.detections().size();
  DetectionFrame frame;
  frame.available = true;
  frame.left_labels = mask_.labels();
  frame.left = mask_.detections();
  return frame;
}

}  // namespace kinetrace::segmentation

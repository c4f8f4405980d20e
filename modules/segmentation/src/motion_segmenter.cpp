#include "kinetrace/segmentation/motion_segmenter.hpp"

#include <algorithm>
#include <string>

#include "dense_kernels.hpp"
#include "kinetrace/core/config_check.hpp"

namespace kinetrace::segmentation {

void MotionSegmenter::carve(const SegmentationConfig& config, const StereoGeometry& geometry, int max_features,
                            Arena& arena, MotionSegmenter& segmenter) {
  segmenter.evidence_ = MotionEvidence(config.motion, geometry, max_features, arena);
  segmenter.clusters_ = MotionClusters(config.motion, geometry, max_features, arena);
  segmenter.memory_ = MotionMemory(config.motion, max_features, arena);
  segmenter.geometry_ = geometry;
  const int step = matching_step(geometry.width_px);
  const int width = (geometry.width_px + step - 1) / step;
  const int height = (geometry.height_px + step - 1) / step;
  segmenter.history_ = FrameHistory(width, height, arena);
  segmenter.right_ = take_image<std::uint8_t>(arena, width, height);
  segmenter.disparity_ = CellDisparity(geometry, arena);
  segmenter.ground_ = GroundPlane(geometry, arena);
  segmenter.blobs_ = MovingBlobs(config.motion, geometry, arena);
  segmenter.blob_of_feature_ = FixedVector<std::int16_t>(arena, static_cast<std::size_t>(max_features));
  segmenter.scratch_ = arena.take<float>(static_cast<std::size_t>(max_features));
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
  history_.clear();
  ground_.clear();
  blobs_.reset();
  mask_.reset();
}

void MotionSegmenter::look(const SegmentationInput& input, std::span<const FeatureMotion> motions) {
  history_.push(input.pair.left, evidence_.T_world_cam(), input.pair.timestamp_ns);
  std::size_t n = 0;
  for (const Feature& f : input.features.first(motions.size())) {
    if (f.has_right()) {
      scratch_[n++] = f.disparity_px();
    }
  }
  if (n < 4 || input.pair.left.empty() || input.pair.right.empty()) {
    disparity_.clear();
    ground_.clear();
    return;
  }
  const auto third = scratch_.begin() + static_cast<std::ptrdiff_t>(n - 3);
  std::nth_element(scratch_.begin(), third, scratch_.begin() + static_cast<std::ptrdiff_t>(n));
  dense_kernels().decimate(input.pair.right, matching_step(input.pair.right.width), right_);
  disparity_.compute(history_.at(0).image, right_, 1.25F * *third + 8.F);
  ground_.fit(disparity_.disparity_px(), ++frames_ * 2654435761U);
}

std::span<const std::int16_t> MotionSegmenter::blobs_of(std::span<const Feature> features) {
  const ImageView<const std::int16_t> blobs = blobs_.blob_of_cell();
  blob_of_feature_.clear();
  for (const Feature& f : features) {
    const int x = static_cast<int>(f.left_px.x()) / kCellPx;
    const int y = static_cast<int>(f.left_px.y()) / kCellPx;
    (void)blob_of_feature_.push_back(blobs.contains(x, y) ? blobs.row(y)[x] : std::int16_t{-1});  // never full
  }
  return blob_of_feature_.span();
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
  look(input, motions);
  const DenseView dense{disparity_, ground_, history_};
  const TemporalTest test(geometry_, history_);
  memory_.begin(interval_ns, input.features.first(motions.size()), mask_.inherited_regions(input.features));
  const std::span<const MotionCluster> clusters =
      clusters_.find(input.features, motions, evidence_.ego_speed_mps(), dense, test, memory_.region_of_feature());
  memory_.update(input.features, motions, clusters, clusters_.cluster_of_feature(),
                 mask_.drawn_regions(input.features));
  const std::span<const MovingBlob> blobs =
      blobs_.find(dense, test, evidence_.T_world_cam(), evidence_.ego_speed_mps());
  memory_.update_blobs(blobs, mask_.drawn_as(blobs, blobs_.blob_of_cell(), dense, test),
                       blobs_of(input.features.first(motions.size())));
  for (std::size_t r = 0; r < memory_.regions().size(); ++r) {
    if (!memory_.regions()[r].moving && mask_.moves_on(memory_.regions()[r], dense, test)) {
      memory_.sustain(r);
    }
  }
  memory_.conclude(input.features, motions);
  counters_.detections_dropped +=
      static_cast<std::uint64_t>(mask_.draw(input.features, motions, memory_, dense, test, blobs_.blob_of_cell()));
  counters_.detections += mask_.detections().size();
  DetectionFrame frame;
  frame.available = true;
  frame.left_labels = mask_.labels();
  frame.left = mask_.detections();
  return frame;
}

}  // namespace kinetrace::segmentation

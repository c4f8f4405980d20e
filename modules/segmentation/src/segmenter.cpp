#include "kinetrace/segmentation/segmenter.hpp"

#include "kinetrace/segmentation/auto_segmenter.hpp"
#include "kinetrace/segmentation/external_segmenter.hpp"
#include "kinetrace/segmentation/mask_file_segmenter.hpp"
#include "kinetrace/segmentation/motion_segmenter.hpp"
#include "kinetrace/segmentation/network_segmenter.hpp"

namespace kinetrace::segmentation {
namespace {

/// Everything is background.
class NoSegmenter final : public Segmenter {
 public:
  [[nodiscard]] Result<DetectionFrame> process(const SegmentationInput& /*input*/) override {
    ++counters_.frames;
    DetectionFrame frame;
    frame.available = true;
    return frame;
  }
  void reset() override {}
};

}  // namespace

std::size_t required_bytes(const SegmentationConfig& config, const StereoGeometry& geometry, int max_features) {
  switch (config.mode) {
    case SegmentationMode::kAuto: return AutoSegmenter::required_bytes(config, geometry, max_features);
    case SegmentationMode::kNone: return 0;
    case SegmentationMode::kMasks: return MaskFileSegmenter::required_bytes(config, geometry);
    case SegmentationMode::kMotion: return MotionSegmenter::required_bytes(config, geometry, max_features);
    case SegmentationMode::kDds: return ExternalSegmenter::required_bytes(config, geometry);
    case SegmentationMode::kOnnx: return NetworkSegmenter::required_bytes(config, geometry, max_features);
  }
  return 0;
}

Result<std::unique_ptr<Segmenter>> make_segmenter(const SegmentationConfig& config, const StereoGeometry& geometry,
                                                  int max_features, Arena& arena, const MaskMakers& makers,
                                                  Workers* workers) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  switch (config.mode) {
    case SegmentationMode::kAuto:
      if (makers.network == nullptr) {
        return MotionSegmenter::create(config, geometry, max_features, arena);
      }
      return AutoSegmenter::create(config, geometry, max_features, arena, makers.network, workers);
    case SegmentationMode::kNone: return std::make_unique<NoSegmenter>();
    case SegmentationMode::kMasks: return MaskFileSegmenter::create(config, geometry, arena);
    case SegmentationMode::kMotion: return MotionSegmenter::create(config, geometry, max_features, arena);
    case SegmentationMode::kDds: return ExternalSegmenter::create(config, geometry, arena, makers.external);
    case SegmentationMode::kOnnx:
      return NetworkSegmenter::create(config, geometry, max_features, arena, makers.network);
  }
  return fail(ErrorCode::kInternal, "segmentation: unknown mode");
}

}  // namespace kinetrace::segmentation

#include "resolved_config.hpp"

#include <algorithm>

namespace kinetrace::pipeline {

PipelineConfig resolved(const PipelineConfig& config) {
  PipelineConfig out = config;
  out.calibration.max_features = out.features.max_features;
  out.background.max_features = out.features.max_features;
  out.object.max_features = out.features.max_features;
  if (segmentation::uses_motion(out.segmentation.mode)) {
    out.features.bucket_px = out.motion_bucket_px;
  }
  out.refinement.max_frames = out.background.window_frames;
  out.refinement.max_points = std::max(out.background.max_points, out.object.max_points);
  return out;
}

}  // namespace kinetrace::pipeline

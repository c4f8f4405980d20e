#include "kinetrace/pipeline/config.hpp"

#include "kinetrace/core/bundle.hpp"
#include "kinetrace/core/config_check.hpp"

namespace kinetrace::pipeline {

Status PipelineConfig::validate() const {
  for (const Status& status : {
           calibration.validate(),
           features.validate(),
           segmentation.validate(),
           tracking.validate(),
           background.validate("background"),
           object.validate("object"),
           refinement.validate(),
           trajectory.validate(),
           check_range("features.motion_bucket_px", motion_bucket_px, 8, 256),
           check_range("background.window_frames", background.window_frames, 3, kMaxWindowFrames),
           check_range("object.stereo_only_min_features", objects.stereo_only_min_features, 1, 1000),
           check_range("object.lost_after_s", objects.lost_after_s, 0.0, 1000.0),
           check_range("memory.budget_mib", memory.budget_mib, 0.0, 1e6),
           check_range("memory.libraries_mib", memory.libraries_mib, 0.0, 1e6),
       }) {
    if (!status) {
      return status;
    }
  }
  if (object.window_frames > background.window_frames) {
    return fail(
        ErrorCode::kInvalidConfig,
        "object.window_frames must not exceed background.window_frames: a frame is final when the camera's pose "
        "is");
  }
  return {};
}

}  // namespace kinetrace::pipeline

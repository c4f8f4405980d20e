#include "kinetrace/pipeline/config.hpp"

#include <cmath>
#include <sstream>

#include "kinetrace/core/bundle.hpp"

namespace kinetrace::pipeline {
namespace {

template <typename T>
Status require_range(const char* key, T value, T low, T high) {
  if (value >= low && value <= high) {  // false for NaN
    return {};
  }
  std::ostringstream message;
  message << key << " must be in [" << low << ", " << high << "], got " << value;
  return fail(ErrorCode::kInvalidConfig, message.str());
}

}  // namespace

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
           require_range("features.motion_bucket_px", motion_bucket_px, 8, 256),
           require_range("background.window_frames", background.window_frames, 3, kMaxWindowFrames),
           require_range("object.stereo_only_min_features", objects.stereo_only_min_features, 1, 1000),
           require_range("object.lost_after_s", objects.lost_after_s, 0.0, 1000.0),
           require_range("memory.budget_mib", memory.budget_mib, 0.0, 1e6),
           require_range("memory.libraries_mib", memory.libraries_mib, 0.0, 1e6),
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

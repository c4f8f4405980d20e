#include "kinetrace/sfm/config.hpp"

#include <sstream>
#include <string>

#include "kinetrace/core/bundle.hpp"

namespace kinetrace::sfm {
namespace {

template <typename T>
Status require_range(const char* prefix, const char* key, T value, T low, T high) {
  if (value >= low && value <= high) {  // false for NaN
    return {};
  }
  std::ostringstream message;
  message << prefix << '.' << key << " must be in [" << low << ", " << high << "], got " << value;
  return fail(ErrorCode::kInvalidConfig, message.str());
}

}  // namespace

Status BodyConfig::validate(const char* prefix) const {
  for (const Status& status : {
           require_range(prefix, "max_features", max_features, 1, 65000),
           require_range(prefix, "max_points", max_points, 4, 60000),
           require_range(prefix, "window_frames", window_frames, 1, kMaxWindowFrames),
           require_range(prefix, "min_inliers", min_inliers, 4, 1000),
           require_range(prefix, "min_inlier_ratio", min_inlier_ratio, 0.0, 1.0),
           require_range(prefix, "min_observations_for_consensus", min_observations_for_consensus, 0, 1000),
           require_range(prefix, "measurement_sigma_px", measurement_sigma_px, 0.01, 10.0),
           require_range(prefix, "min_measurement_sigma_px", min_measurement_sigma_px, 0.01, measurement_sigma_px),
           require_range(prefix, "gate_sigma", gate_sigma, 1.0, 100.0),
           require_range(prefix, "ransac_max_hypotheses", ransac_max_hypotheses, 1, 10000),
           require_range(prefix, "min_disparity_px", min_disparity_px, 0.1, 100.0),
           require_range(prefix, "min_parallax_deg", min_parallax_deg, 0.05, 90.0),
           require_range(prefix, "keyframe_motion_px", keyframe_motion_px, 0.0, 1000.0),
           require_range(prefix, "keyframe_overlap", keyframe_overlap, 0.0, 1.0),
           require_range(prefix, "turn_rate_radps", turn_rate_radps, 0.0, 100.0),
           require_range(prefix, "reject_after_frames", reject_after_frames, 1, 250),
       }) {
    if (!status) {
      return status;
    }
  }
  return {};
}

}  // namespace kinetrace::sfm

#include "kinetrace/sfm/config.hpp"

#include <string>

#include "kinetrace/core/bundle.hpp"
#include "kinetrace/core/config_check.hpp"

namespace kinetrace::sfm {

Status BodyConfig::validate(const char* prefix) const {
  const std::string group = std::string(prefix) + '.';
  return first_failure({
      check_range(group + "max_features", max_features, 1, 65000),
      check_range(group + "max_points", max_points, 4, 60000),
      check_range(group + "window_frames", window_frames, 1, kMaxWindowFrames),
      check_range(group + "min_inliers", min_inliers, 4, 1000),
      check_range(group + "min_inlier_ratio", min_inlier_ratio, 0.0, 1.0),
      check_range(group + "min_observations_for_consensus", min_observations_for_consensus, 0, 1000),
      check_range(group + "measurement_sigma_px", measurement_sigma_px, 0.01, 10.0),
      check_range(group + "min_measurement_sigma_px", min_measurement_sigma_px, 0.01, measurement_sigma_px),
      check_range(group + "gate_sigma", gate_sigma, 1.0, 100.0),
      check_range(group + "ransac_max_hypotheses", ransac_max_hypotheses, 1, 10000),
      check_range(group + "min_disparity_px", min_disparity_px, 0.1, 100.0),
      check_range(group + "min_parallax_deg", min_parallax_deg, 0.05, 90.0),
      check_range(group + "keyframe_motion_px", keyframe_motion_px, 0.0, 1000.0),
      check_range(group + "keyframe_overlap", keyframe_overlap, 0.0, 1.0),
      check_range(group + "turn_rate_radps", turn_rate_radps, 0.0, 100.0),
      check_range(group + "reject_after_frames", reject_after_frames, 1, 250),
  });
}

}  // namespace kinetrace::sfm

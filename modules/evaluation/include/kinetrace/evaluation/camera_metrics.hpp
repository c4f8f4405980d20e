// Errors of the camera's trajectory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "kinetrace/core/se3.hpp"
#include "kinetrace/evaluation/error_statistics.hpp"

namespace kinetrace::evaluation {

/// The camera in one frame, true and estimated. The two worlds may differ by a rigid motion.
struct PosePair {
  std::int64_t frame = 0;
  Se3 T_world_cam_true;
  Se3 T_world_cam;
};

/// Errors over the sub-trajectories of one length.
struct SegmentErrors {
  double length_m = 0.0;
  std::size_t count = 0;  ///< Sub-trajectories, one from each frame with enough remaining path.
  double t_rel_percent = 0.0;
  double r_rel_deg_per_m = 0.0;
};

/// Distances of the positions from the truth in m, after alignment with the true trajectory (absolute trajectory error;
/// Sturm et al., IROS 2012).
struct AbsoluteErrors {
  ErrorStatistics first;  ///< By the first pose: drift shows in full.
  ErrorStatistics se3;    ///< By the rigid motion with the least squares (Umeyama, PAMI 1991); from three frames on.
  ErrorStatistics sim3;   ///< By the similarity with the least squares; none for a stationary camera (within 0.1 m).
  std::optional<double> scale;  ///< Of that similarity: true length over estimated length.
};

struct CameraMetrics {
  std::size_t frames = 0;
  double path_m = 0.0;  ///< Length of the true path.
  AbsoluteErrors ate_m;
  /// From one frame to the next (relative pose error; Sturm et al., IROS 2012). Only frames with consecutive numbers.
  ErrorStatistics rpe_translation_m;
  ErrorStatistics rpe_rotation_deg;
  /// Means over all sub-trajectories of `segments` (Geiger et al., CVPR 2012); none if the path is too short for any.
  std::optional<double> t_rel_percent;
  std::optional<double> r_rel_deg_per_m;
  std::vector<SegmentErrors> segments;  ///< By length; those that fit into the path.
};

/// `pairs` by frame. Sub-trajectories have KITTI's lengths (100, 200 .. 800 m) if the true path is 200 m or longer,
/// else 5, 10, 20, 50 and 100 m. They start at every frame and end with the first frame that is at least that far along
/// the true path; errors are divided by that distance, not by the nominal one, as the two differ noticeably for short
/// lengths.
[[nodiscard]] CameraMetrics evaluate_camera(std::span<const PosePair> pairs);

}  // namespace kinetrace::evaluation

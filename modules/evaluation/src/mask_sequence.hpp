// Mask overlaps of a frame, reduced from its pixels.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace kinetrace::evaluation {

inline constexpr double kRounding = 2.220446049250313e-16;  ///< Slack of TrackEval's comparisons with thresholds.
inline constexpr double kMotsIou = 0.5;                     ///< Matching threshold of (s)MOTSA and ignore regions.

/// The masks of one class in one frame.
struct MaskPairs {
  std::vector<std::int64_t> truth_ids;
  std::vector<std::int64_t> result_ids;
  Eigen::MatrixXd iou;  ///< truth_ids x result_ids.
};

}  // namespace kinetrace::evaluation

// Left-right correspondences, found without knowledge of the rig.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace kinetrace::self_calibration {

struct PointPair {
  Eigen::Vector2d left_px;
  Eigen::Vector2d right_px;
};

/// Pairs of two images: scale-invariant features (Lowe, IJCV 2004), mutual and clearly better than the second best.
/// They contain outliers.
[[nodiscard]] std::vector<PointPair> find_point_pairs(const cv::Mat& left, const cv::Mat& right);

}  // namespace kinetrace::self_calibration

// A lens in the form OpenCV takes it.
#pragma once

#include <opencv2/core.hpp>

#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::hal {

[[nodiscard]] inline cv::Matx33d camera_matrix(const CameraModel& camera) {
  return {camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1};
}

[[nodiscard]] inline cv::Mat distortion_vector(const CameraModel& camera) {
  const int count = camera.lens == LensModel::kEquidistant ? 4 : 8;
  return cv::Mat(count, 1, CV_64F, const_cast<double*>(camera.distortion.data())).clone();
}

[[nodiscard]] inline cv::Matx33d to_opencv(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

[[nodiscard]] inline Eigen::Matrix3d to_eigen(const cv::Matx33d& m) {
  Eigen::Matrix3d out;
  out << m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2);
  return out;
}

}  // namespace kinetrace::hal

// Raw images rectified by an assumed rig, so that matches lie near rows and patches look alike.
#pragma once

#include <array>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "kinetrace/core/image_view.hpp"
#include "rig_model.hpp"

namespace kinetrace::self_calibration {

/// A smooth map of both views. Measurements in warped images are mapped back exactly, so errors of the assumed rig make
/// matching harder but cause no bias. Canvases hold the raw images' content, up to one and a half times as wide.
class ViewWarp {
 public:
  explicit ViewWarp(const RigModel& rig);

  /// Eight bits; outside the raw image, its border's pixels are repeated.
  [[nodiscard]] cv::Mat warped(int view, GrayView raw) const;
  [[nodiscard]] Eigen::Vector2d to_raw(int view, const Eigen::Vector2d& warped_px) const;
  [[nodiscard]] Eigen::Vector2d to_warped(int view, const Eigen::Vector2d& raw_px) const;
  /// Non-zero where the raw image has data, a patch's width from its border.
  [[nodiscard]] const cv::Mat& inside(int view) const { return inside_[static_cast<std::size_t>(view)]; }

 private:
  void choose_canvas();
  void fill_tables(int view);

  RigModel rig_;
  std::array<Eigen::Matrix3d, 2> R_common_view_;  ///< From each camera into the common orientation.
  double focal_px_ = 0.0;
  Eigen::Vector2d centre_px_ = Eigen::Vector2d::Zero();
  cv::Size canvas_;
  std::array<cv::Mat, 2> table_;  ///< Raw position of every warped pixel, two floats.
  std::array<cv::Mat, 2> inside_;
};

}  // namespace kinetrace::self_calibration

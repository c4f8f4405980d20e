// Raw images as an assumed rig would rectify them, so that matches lie near rows and patches look alike.
#pragma once

#include <array>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "kinetrace/core/image_view.hpp"
#include "rig_model.hpp"

namespace kinetrace::self_calibration {

/// A smooth map of both views. What is measured in warped images is carried back exactly, so an assumed rig that is
/// wrong makes matching harder, not biased. Canvases hold what the raw images show, up to one and a half times as wide.
class ViewWarp {
 public:
  explicit ViewWarp(const RigModel& rig);

  /// Eight bits, nothing outside the raw image: the border's pixels go on.
  [[nodiscard]] cv::Mat warped(int view, GrayView raw) const;
  [[nodiscard]] Eigen::Vector2d to_raw(int view, const Eigen::Vector2d& warped_px) const;
  [[nodiscard]] Eigen::Vector2d to_warped(int view, const Eigen::Vector2d& raw_px) const;
  /// Non-zero where the raw image has data, a patch's width from its border.
  [[nodiscard]] const cv::Mat& inside(int view) const { return inside_[static_cast<std::size_t>(view)]; }

 private:
  void choose_canvas();
  void fill_tables(int view);

  RigModel rig_;
  std::array<Eigen::Matrix3d, 2> R_common_view_;  ///< From each camera into the orientation both get.
  double focal_px_ = 0.0;
  Eigen::Vector2d centre_px_ = Eigen::Vector2d::Zero();
  cv::Size canvas_;
  std::array<cv::Mat, 2> table_;  ///< Raw position of every warped pixel, two floats.
  std::array<cv::Mat, 2> inside_;
};

}  // namespace kinetrace::self_calibration

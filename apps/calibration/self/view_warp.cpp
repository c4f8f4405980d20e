#include "view_warp.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace kinetrace::self_calibration {
namespace {

constexpr int kPatchMargin_px = 10;

/// Rotation from the left camera into the common orientation: x along the baseline, z as near as possible to both
/// optical axes.
Eigen::Matrix3d common_orientation(const Se3& T_right_left) {
  // The right camera's centre in the left camera's frame.
  const Eigen::Vector3d x = -(T_right_left.rotation.transpose() * T_right_left.translation).normalized();
  const Eigen::Vector3d look = Eigen::Vector3d::UnitZ() + T_right_left.rotation.transpose().col(2);
  Eigen::Matrix3d rows;
  rows.row(0) = x;
  rows.row(1) = look.cross(x).normalized();
  rows.row(2) = rows.row(0).cross(rows.row(1));
  return rows;
}

std::vector<Eigen::Vector2d> border_of(const ImageSize& size) {
  constexpr int kSteps = 16;
  std::vector<Eigen::Vector2d> border;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = static_cast<double>(size.width_px - 1) * i / kSteps;
    const double y = static_cast<double>(size.height_px - 1) * i / kSteps;
    border.insert(border.end(), {{x, 0.0}, {x, size.height_px - 1.0}, {0.0, y}, {size.width_px - 1.0, y}});
  }
  return border;
}

}  // namespace

ViewWarp::ViewWarp(const RigModel& rig) : rig_(rig) {
  const Se3 T_right_left = rig.T_right_left();
  R_common_view_[0] = common_orientation(T_right_left);
  R_common_view_[1] = R_common_view_[0] * T_right_left.rotation.transpose();
  choose_canvas();
  fill_tables(0);
  fill_tables(1);
}

void ViewWarp::choose_canvas() {
  constexpr double kWidest = 1.5;
  focal_px_ = rig_.focal_px(0);
  centre_px_.setZero();
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9);
  Eigen::Vector2d high = -low;
  for (int view = 0; view < 2; ++view) {
    for (const Eigen::Vector2d& pixel : border_of(rig_.size)) {
      const Eigen::Vector2d at = to_warped(view, pixel);
      low = low.cwiseMin(at);
      high = high.cwiseMax(at);
    }
  }
  const Eigen::Vector2d widest(kWidest * rig_.size.width_px, kWidest * rig_.size.height_px);
  const Eigen::Vector2d extent = (high - low).cwiseMin(widest);
  canvas_ = {static_cast<int>(extent.x()) + 1, static_cast<int>(extent.y()) + 1};
  centre_px_ = 0.5 * extent - 0.5 * (low + high);
}

void ViewWarp::fill_tables(int view) {
  const auto v = static_cast<std::size_t>(view);
  // Beyond the lens's field of view, the polynomial may bend rays back into the image.
  double farthest2 = 0.0;
  for (const Eigen::Vector2d& pixel : border_of(rig_.size)) {
    farthest2 = std::max(farthest2, unproject(rig_.lens[v], rig_.size, pixel).squaredNorm());
  }
  table_[v].create(canvas_, CV_32FC2);
  inside_[v].create(canvas_, CV_8U);
  const Eigen::Matrix3d R_view_common = R_common_view_[v].transpose();
  for (int y = 0; y < canvas_.height; ++y) {
    for (int x = 0; x < canvas_.width; ++x) {
      const Eigen::Vector3d ray = R_view_common * ((Eigen::Vector2d(x, y) - centre_px_) / focal_px_).homogeneous();
      Eigen::Vector2d at(-1e4, -1e4);
      if (ray.z() > 0.0 && ray.hnormalized().squaredNorm() < 1.05 * farthest2) {
        project(rig_.lens[v].data(), rig_.size, ray.data(), at.data());
      }
      table_[v].at<cv::Vec2f>(y, x) = {static_cast<float>(at.x()), static_cast<float>(at.y())};
      const bool holds =
          at.x() >= 1.0 && at.y() >= 1.0 && at.x() <= rig_.size.width_px - 2.0 && at.y() <= rig_.size.height_px - 2.0;
      inside_[v].at<std::uint8_t>(y, x) = holds ? 255 : 0;
    }
  }
  const cv::Mat patch = cv::Mat::ones(2 * kPatchMargin_px + 1, 2 * kPatchMargin_px + 1, CV_8U);
  cv::erode(inside_[v], inside_[v], patch, {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
}

cv::Mat ViewWarp::warped(int view, GrayView raw) const {
  const cv::Mat source(raw.height, raw.width, CV_8U, const_cast<std::uint8_t*>(raw.data),
                       static_cast<std::size_t>(raw.stride));
  cv::Mat target;
  cv::remap(source, target, table_[static_cast<std::size_t>(view)], cv::noArray(), cv::INTER_CUBIC,
            cv::BORDER_REPLICATE);
  return target;
}

Eigen::Vector2d ViewWarp::to_raw(int view, const Eigen::Vector2d& warped_px) const {
  const auto v = static_cast<std::size_t>(view);
  const Eigen::Vector3d ray = R_common_view_[v].transpose() * ((warped_px - centre_px_) / focal_px_).homogeneous();
  Eigen::Vector2d at;
  project(rig_.lens[v].data(), rig_.size, ray.data(), at.data());
  return at;
}

Eigen::Vector2d ViewWarp::to_warped(int view, const Eigen::Vector2d& raw_px) const {
  const auto v = static_cast<std::size_t>(view);
  const Eigen::Vector3d ray = R_common_view_[v] * unproject(rig_.lens[v], rig_.size, raw_px).homogeneous();
  return focal_px_ * ray.hnormalized() + centre_px_;
}

}  // namespace kinetrace::self_calibration

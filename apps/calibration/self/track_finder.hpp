// Tracks points through a window of frames and from left to right, in warped images.
#pragma once

#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "kinetrace/core/frame.hpp"
#include "kinetrace/features/affine_template.hpp"
#include "track_window.hpp"
#include "view_warp.hpp"

namespace kinetrace::self_calibration {

/// Search range of left-right matches in warped images.
struct StereoSearch {
  double least_disparity_px = 0.0;
  double most_disparity_px = 0.0;
  int rows_px = 4;  ///< Up and down.
};

class TrackFinder {
 public:
  TrackFinder(const ViewWarp& warp, const StereoSearch& search) : warp_(&warp), search_(search) {}

  /// The next frame of the window.
  void add(const StereoFrame& frame, std::size_t place);
  /// The window so far, without points seen in one frame only; starts a new window.
  [[nodiscard]] TrackWindow take();

 private:
  struct Point {
    std::size_t track = 0;
    features::AffineTemplate patch;  ///< Of its first left image.
    features::AffinePlace left;      ///< In warped images, like all below.
    Eigen::Vector2d flow_px = Eigen::Vector2d::Zero();
    std::optional<features::AffinePlace> right;
  };
  struct Images {
    cv::Mat left;
    cv::Mat right;
    std::vector<cv::Mat> pyramid;  ///< Of the left one.
  };

  [[nodiscard]] Images prepare(const StereoFrame& frame) const;
  void follow(const Images& now);
  void match_right(const Images& now);
  void find_new(const Images& now);
  void record();
  [[nodiscard]] bool is_inside(int view, const Eigen::Vector2d& at) const;
  [[nodiscard]] std::optional<Eigen::Vector2d> search_row(const Images& now, const Eigen::Vector2d& left_px) const;

  const ViewWarp* warp_;
  StereoSearch search_;
  TrackWindow window_;
  std::vector<Point> points_;
  Images before_;
};

}  // namespace kinetrace::self_calibration

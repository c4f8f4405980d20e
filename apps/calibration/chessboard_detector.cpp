#include <algorithm>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "detector.hpp"
#include "opencv_image.hpp"

namespace kinetrace::calibration {
namespace {

using Points = std::vector<cv::Point2f>;

class ChessboardDetector final : public TargetDetector {
 public:
  explicit ChessboardDetector(const Target& target)
      : size_(target.columns, target.rows), is_symmetric_(target.columns % 2 == target.rows % 2) {}

  std::vector<Corner> detect(GrayView image) override { return numbered(find(image)); }

  BoardView detect_pair(GrayView left, GrayView right) override {
    Points in_left = find(left);
    if (in_left.empty()) {
      return {};
    }
    Points in_right = find(right);
    if (is_symmetric_ && !in_right.empty() && along(in_left).dot(along(in_right)) < 0) {
      std::reverse(in_right.begin(), in_right.end());
    }
    return {.left = numbered(in_left), .right = numbered(in_right)};
  }

 private:
  Points find(GrayView view) {
    const cv::Mat image = as_mat(view);
    Points points;
    if (!cv::findChessboardCornersSB(image, size_, points, cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_ACCURACY)) {
      return {};
    }
    refine(image, points);
    if (!is_symmetric_ && is_upside_down(image, points)) {
      std::reverse(points.begin(), points.end());
    }
    return points;
  }

  // By the gradients around each corner, in windows reaching to the neighbours: half the error on noisy images.
  void refine(const cv::Mat& image, Points& points) const {
    double nearest_px = 1e9;
    for (int i = 0; i + 1 < static_cast<int>(points.size()); ++i) {
      const auto at = static_cast<std::size_t>(i);
      if ((i + 1) % size_.width != 0) {
        nearest_px = std::min(nearest_px, cv::norm(points[at] - points[at + 1]));
      }
      if (i + size_.width < static_cast<int>(points.size())) {
        nearest_px = std::min(nearest_px, cv::norm(points[at] - points[at + static_cast<std::size_t>(size_.width)]));
      }
    }
    constexpr double kMaxHalf_px = 9.0;
    const int half_px = static_cast<int>(std::min(0.4 * nearest_px, kMaxHalf_px));
    if (half_px >= 2) {
      const Points found = points;
      cv::cornerSubPix(image, points, {half_px, half_px}, {-1, -1},
                       {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 60, 1e-3});
      for (std::size_t i = 0; i < points.size(); ++i) {
        constexpr double kMaxMove_px = 1.0;
        if (cv::norm(points[i] - found[i]) > kMaxMove_px) {
          points[i] = found[i];  // The window contained another edge.
        }
      }
    }
  }

  // Direction of the first rows in the image.
  cv::Point2f along(const Points& points) const {
    return points[static_cast<std::size_t>(size_.width - 1)] - points.front();
  }

  // Boards with an odd and an even side have one black and one white square inside their first and last corner.
  bool is_upside_down(const cv::Mat& image, const Points& points) const {
    const auto brightness = [&image](const cv::Point2f& a, const cv::Point2f& b) {
      cv::Mat patch;
      cv::getRectSubPix(image, {3, 3}, (a + b) / 2, patch);
      return cv::mean(patch)[0];
    };
    const auto width = static_cast<std::size_t>(size_.width);
    const std::size_t last = points.size() - 1;
    return brightness(points[0], points[width + 1]) > brightness(points[last], points[last - width - 1]);
  }

  static std::vector<Corner> numbered(const Points& points) {
    std::vector<Corner> corners;
    for (const cv::Point2f& point : points) {
      corners.push_back({static_cast<int>(corners.size()), {point.x, point.y}});
    }
    return corners;
  }

  cv::Size size_;
  bool is_symmetric_;  ///< When rotated by 180 degrees.
};

}  // namespace

std::unique_ptr<TargetDetector> make_chessboard_detector(const Target& target) {
  return std::make_unique<ChessboardDetector>(target);
}

Result<std::unique_ptr<TargetDetector>> make_detector(const Target& target) {
  switch (target.kind) {
    case TargetKind::kChessboard: return make_chessboard_detector(target);
    case TargetKind::kCharuco: return make_charuco_detector(target);
    case TargetKind::kAprilGrid: return make_april_detector(target);
  }
  return fail(ErrorCode::kInternal, "unknown kind of target");
}

}  // namespace kinetrace::calibration

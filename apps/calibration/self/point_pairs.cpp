#include "point_pairs.hpp"

#include <opencv2/features2d.hpp>

namespace kinetrace::self_calibration {
namespace {

struct Features {
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;
};

Features describe(const cv::Mat& image) {
  constexpr int kMaxFeatures = 1500;
  constexpr double kContrast = 0.02;  // Half of the usual, for features in areas of low contrast.
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create(kMaxFeatures, 3, kContrast);
  Features features;
  sift->detectAndCompute(image, cv::noArray(), features.points, features.descriptors);
  return features;
}

/// For each feature of `from` the index of its match in `to`, or -1.
std::vector<int> distinct_matches(const Features& from, const Features& to) {
  constexpr float kRatio = 0.8F;
  std::vector<std::vector<cv::DMatch>> nearest;
  cv::BFMatcher(cv::NORM_L2).knnMatch(from.descriptors, to.descriptors, nearest, 2);
  std::vector<int> match(from.points.size(), -1);
  for (const std::vector<cv::DMatch>& candidates : nearest) {
    if (candidates.size() == 2 && candidates[0].distance < kRatio * candidates[1].distance) {
      match[static_cast<std::size_t>(candidates[0].queryIdx)] = candidates[0].trainIdx;
    }
  }
  return match;
}

Eigen::Vector2d position(const cv::KeyPoint& point) {
  return {static_cast<double>(point.pt.x), static_cast<double>(point.pt.y)};
}

}  // namespace

std::vector<PointPair> find_point_pairs(const cv::Mat& left, const cv::Mat& right) {
  const Features a = describe(left);
  const Features b = describe(right);
  std::vector<PointPair> pairs;
  if (a.points.size() < 2 || b.points.size() < 2) {
    return pairs;
  }
  const std::vector<int> forward = distinct_matches(a, b);
  const std::vector<int> backward = distinct_matches(b, a);
  for (std::size_t i = 0; i < forward.size(); ++i) {
    const int j = forward[i];
    if (j >= 0 && backward[static_cast<std::size_t>(j)] == static_cast<int>(i)) {
      pairs.push_back({position(a.points[i]), position(b.points[static_cast<std::size_t>(j)])});
    }
  }
  return pairs;
}

}  // namespace kinetrace::self_calibration

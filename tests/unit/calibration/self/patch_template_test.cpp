#include "patch_template.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace kinetrace::self_calibration {
namespace {

/// Waves of several directions, seen through an affine map about `centre`.
cv::Mat waves(const Eigen::Matrix2d& shape, const Eigen::Vector2d& shift_px, double gain, double offset) {
  const Eigen::Vector2d centre(50.0, 50.0);
  cv::Mat image(100, 100, CV_32F);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const Eigen::Vector2d p = shape.inverse() * (Eigen::Vector2d(x, y) - centre - shift_px);
      const double value = 30.0 * std::sin(0.35 * p.x() + 0.2 * p.y()) +
                           25.0 * std::sin(0.3 * p.y() - 0.1 * p.x() + 1) + 0.05 * p.x() * p.y();
      image.at<float>(y, x) = static_cast<float>(gain * (value + 100.0) + offset);
    }
  }
  return image;
}

TEST(PatchTemplate, FindsAPatchUnderAnAffineMapGainAndOffset) {
  Eigen::Matrix2d shape;
  shape << 1.15, 0.05, -0.04, 0.95;
  const Eigen::Vector2d shift_px(0.7, -0.4);
  const cv::Mat source = waves(Eigen::Matrix2d::Identity(), {0.0, 0.0}, 1.0, 0.0);
  const auto patch = PatchTemplate::make(source, {50.0, 50.0});
  ASSERT_TRUE(patch);
  const auto place = patch->align(waves(shape, shift_px, 0.8, 15.0), {{50.0, 50.0}}, 3.0, 0.9);
  ASSERT_TRUE(place);
  EXPECT_LT((place->position - Eigen::Vector2d(50.7, 49.6)).norm(), 0.02);
  EXPECT_LT((place->shape - shape).norm(), 0.03);
}

TEST(PatchTemplate, IsEmptyWhereNothingIsToBeSeen) {
  EXPECT_FALSE(PatchTemplate::make(cv::Mat(100, 100, CV_32F, cv::Scalar(80)), {50.0, 50.0}));
}

TEST(PatchTemplate, IsEmptyAtTheBorder) {
  const cv::Mat image = waves(Eigen::Matrix2d::Identity(), {0.0, 0.0}, 1.0, 0.0);
  EXPECT_FALSE(PatchTemplate::make(image, {6.0, 50.0}));
  EXPECT_TRUE(PatchTemplate::make(image, {11.0, 50.0}));
}

TEST(PatchTemplate, DoesNotReachFartherThanAsked) {
  const cv::Mat source = waves(Eigen::Matrix2d::Identity(), {0.0, 0.0}, 1.0, 0.0);
  const auto patch = PatchTemplate::make(source, {50.0, 50.0});
  ASSERT_TRUE(patch);
  const cv::Mat moved = waves(Eigen::Matrix2d::Identity(), {2.0, 0.0}, 1.0, 0.0);
  EXPECT_TRUE(patch->align(moved, {{50.0, 50.0}}, 3.0, 0.9));
  EXPECT_FALSE(patch->align(moved, {{50.0, 50.0}}, 1.0, 0.9));
}

}  // namespace
}  // namespace kinetrace::self_calibration

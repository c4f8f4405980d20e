// Position of an object from one frame's stereo.
#include "stereo_observation.hpp"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "rendered_world.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr std::uint8_t kLabel = 2;
constexpr double kMinDisparity_px = 1.0;

Feature feature_at(float u, float v, float disparity_px, std::uint8_t label = kLabel) {
  Feature feature;
  feature.body = label;
  feature.left_px = {u, v + 100.F};  // Another row than that of the pair.
  feature.v_px = v;
  feature.u_right_px = u - disparity_px;
  return feature;
}

StereoObservation observe_features(std::vector<Feature> features) {
  return observe_stereo({.frame_index = 0, .timestamp_ns = 0, .features = features}, kLabel, kMinDisparity_px);
}

TEST(StereoObservation, SeesNothingInNothing) {
  const StereoObservation observation = observe_features({});
  EXPECT_EQ(observation.features, 0);
  EXPECT_TRUE(observation.uvd_px.isZero());
}

TEST(StereoObservation, OfOneFeatureIsThatFeature) {
  const StereoObservation observation = observe_features({feature_at(30.F, 40.F, 5.F)});
  EXPECT_EQ(observation.features, 1);
  EXPECT_EQ(observation.uvd_px, Eigen::Vector3d(30.0, 40.0, 5.0));
}

TEST(StereoObservation, TakesTheMedianOfEachCoordinate) {
  // The middle ones belong to three different features.
  std::vector<Feature> features{feature_at(30.F, 90.F, 5.F), feature_at(10.F, 40.F, 6.F), feature_at(20.F, 10.F, 99.F)};
  EXPECT_EQ(observe_features(features).uvd_px, Eigen::Vector3d(20.0, 40.0, 6.0));
  // Of an even number, the upper one of the two in the middle.
  features.push_back(feature_at(25.F, 50.F, 7.F));
  const StereoObservation even = observe_features(features);
  EXPECT_EQ(even.features, 4);
  EXPECT_EQ(even.uvd_px, Eigen::Vector3d(25.0, 50.0, 7.0));
}

TEST(StereoObservation, LeavesOutOtherBodiesAndWhatHasNoDisparityToSpeakOf) {
  Feature unmatched = feature_at(1.F, 1.F, 1.F);
  unmatched.u_right_px = kNoRight;
  const StereoObservation observation =
      observe_features({feature_at(1.F, 1.F, 50.F, kBackgroundLabel), feature_at(1.F, 1.F, 50.F, kLabel + 1), unmatched,
                        feature_at(1.F, 1.F, 0.875F), feature_at(30.F, 40.F, 1.F)});
  EXPECT_EQ(observation.features, 1);
  EXPECT_EQ(observation.uvd_px, Eigen::Vector3d(30.0, 40.0, 1.0));
}

TEST(StereoObservation, TellsHowManyAgreeHowFarAwayItIs) {
  EXPECT_EQ(observe_features({}).agreeing, 0);
  EXPECT_EQ(observe_features({feature_at(1.F, 1.F, 9.F), feature_at(1.F, 1.F, 7.F)}).agreeing, 1)
      << "blends with another";
  EXPECT_EQ(observe_features({feature_at(1.F, 1.F, 3.F), feature_at(1.F, 1.F, 2.5F)}).agreeing, 2) << "noise";
  EXPECT_EQ(observe_features({feature_at(1.F, 1.F, 40.F), feature_at(1.F, 1.F, 37.F)}).agreeing, 2) << "its two ends";
}

TEST(StereoObservation, TellsHowTheFeaturesMovedThatWereThereBefore) {
  std::vector<Feature> features{feature_at(30.F, 40.F, 5.F), feature_at(50.F, 60.F, 5.F), feature_at(90.F, 90.F, 5.F)};
  for (std::size_t i = 0; i < 2; ++i) {
    features[i].age_frames = 3;
    features[i].previous_left_px = features[i].left_px - Eigen::Vector2f(4.F, -2.F);
  }
  const StereoObservation observation = observe_features(features);
  EXPECT_EQ(observation.features, 3);
  EXPECT_EQ(observation.motion.features, 2) << "the third is new";
  EXPECT_EQ(observation.motion.now_px, Eigen::Vector2d(50.0, 160.0)) << "rows of the left image";
  EXPECT_EQ(observation.motion.before_px, Eigen::Vector2d(46.0, 162.0));
}

TEST(StereoObservation, LooksAtNoMoreThan256Features) {
  std::vector<Feature> features(256, feature_at(30.F, 40.F, 5.F));
  EXPECT_EQ(observe_features(features).features, 256);
  features.resize(600, feature_at(90.F, 90.F, 90.F));
  const StereoObservation observation = observe_features(features);
  EXPECT_EQ(observation.features, 256);
  EXPECT_EQ(observation.uvd_px, Eigen::Vector3d(30.0, 40.0, 5.0));
}

TEST(StereoObservation, LiesWhereTheRigProjectsItFrom) {
  const StereoGeometry rig = test::small_rig();
  const Eigen::Vector3d p_cam(1.5, -0.4, 8.0);
  const Eigen::Vector3d uvr = rig.project(p_cam);
  EXPECT_TRUE(position_in_camera(
                  rig, {.features = 3, .uvd_px = {uvr.x(), uvr.y(), uvr.x() - uvr.z()}, .agreeing = 3, .motion = {}})
                  .isApprox(p_cam, 1e-12));
}

/// 20 x 10 pixels with a triangle of `kLabel`: row y has the columns 4 to 4 + y.
class Triangle {
 public:
  static constexpr int kWidth = 20;
  static constexpr int kHeight = 10;
  Triangle() : pixels_(std::size_t{kWidth} * kHeight, kBackgroundLabel) {
    for (int y = 0; y < kHeight; ++y) {
      std::fill_n(pixels_.begin() + y * kWidth + 4, y + 1, kLabel);
    }
  }
  [[nodiscard]] LabelView view() const { return {pixels_.data(), kWidth, kHeight, kWidth}; }

 private:
  std::vector<std::uint8_t> pixels_;
};

TEST(MeanColumn, WeighsEveryPixelAlike) {
  const Triangle triangle;
  EXPECT_DOUBLE_EQ(mean_column(triangle.view(), {0, 0, 20, 1}, kLabel), 4.0) << "one pixel";
  EXPECT_DOUBLE_EQ(mean_column(triangle.view(), {0, 0, 20, 2}, kLabel), (4.0 + 4.0 + 5.0) / 3.0);
  EXPECT_DOUBLE_EQ(mean_column(triangle.view(), {0, 0, 20, 10}, kLabel), 7.0);
}

TEST(MeanColumn, IsTheMiddleOfTheBoxWithoutPixels) {
  const Triangle triangle;
  EXPECT_DOUBLE_EQ(mean_column(triangle.view(), {6, 0, 11, 10}, kLabel + 1), 8.0);
  EXPECT_DOUBLE_EQ(mean_column(triangle.view(), {14, 2, 16, 5}, kLabel), 14.5);
  EXPECT_DOUBLE_EQ(mean_column({}, {6, 0, 11, 10}, kLabel), 8.0) << "no masks";
}

TEST(MeanColumn, CountsOnlyWhatIsInTheBoxAndInTheImage) {
  const Triangle triangle;
  EXPECT_DOUBLE_EQ(mean_column(triangle.view(), {6, 9, 9, 10}, kLabel), 7.0);
  EXPECT_DOUBLE_EQ(mean_column(triangle.view(), {-5, -7, 90, 30}, kLabel), 7.0);
  EXPECT_DOUBLE_EQ(mean_column(triangle.view(), {-9, 0, -1, 10}, kLabel), -5.5) << "beside the image";
}

}  // namespace
}  // namespace kinetrace::pipeline

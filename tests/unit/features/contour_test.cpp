// Features of narrow foreground objects, with and without labels of the pixels.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "front_end_harness.hpp"

namespace kinetrace::features {
namespace {

using Eigen::Vector2d;
using testing::Harness;
using testing::Image;
using testing::median;
using testing::StereoImage;
using testing::Texture;

constexpr int kWidth = 400;
constexpr int kHeight = 240;
constexpr double kStripWidth_px = 22.0;
constexpr int kStrips = 4;
constexpr std::uint8_t kStripLabel = 1;

/// Vertical strips in front of a wall. Both have texture, and move along the rows independently.
struct Fence {
  double strip_disparity_px = 26.3;
  double wall_disparity_px = 10.6;
  double strip_shift_px = 0.0;
  double wall_shift_px = 0.0;

  [[nodiscard]] bool on_strip(double x) const {
    const double from_first = x - strip_shift_px - 70.0;
    return from_first >= 0.0 && from_first < 80.0 * kStrips && std::fmod(from_first, 80.0) < kStripWidth_px;
  }

  [[nodiscard]] StereoImage render(unsigned seed) const {
    const Texture strip(41);
    const Texture wall(42);
    const auto view = [&](double strip_px, double wall_px, unsigned noise) {
      return testing::render(
          kWidth, kHeight,
          [&](const Vector2d& p) {
            const double x = p.x() + strip_px;
            return on_strip(x) ? strip({x - strip_shift_px, p.y()}) : wall({p.x() + wall_px - wall_shift_px, p.y()});
          },
          2.0, noise);
    };
    return {view(0.0, 0.0, 2 * seed), view(strip_disparity_px, wall_disparity_px, 2 * seed + 1)};
  }

  [[nodiscard]] Image labels() const {
    Image labels(kWidth, kHeight, kBackgroundLabel);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        labels.pixels().at(x, y) = on_strip(x) ? kStripLabel : kBackgroundLabel;
      }
    }
    return labels;
  }
};

/// The same density on the background as on objects.
FeatureConfig dense() {
  FeatureConfig config;
  config.bucket_px = 8;
  config.object_bucket_px = 8;
  config.max_features = 3000;
  config.max_background_features = 1500;
  config.max_features_per_object = 400;
  return config;
}

/// Errors of the strips' features, px.
std::vector<double> disparity_errors(bool with_labels) {
  const Fence fence;
  const Image labels = fence.labels();
  Harness harness(dense(), kWidth, kHeight);
  std::vector<double> errors;
  for (const Feature& feature : harness.process(fence.render(1), with_labels ? labels.view() : LabelView{})) {
    if (feature.has_right() && fence.on_strip(double{feature.left_px.x()})) {
      errors.push_back(std::abs(double{feature.disparity_px()} - fence.strip_disparity_px));
    }
  }
  return errors;
}

TEST(Contours, NarrowThingsHaveTheirOwnDisparity) {
  const std::vector<double> with = disparity_errors(true);
  const std::vector<double> without = disparity_errors(false);
  EXPECT_GT(with.size(), 60U);
  EXPECT_GT(without.size(), 40U);
  EXPECT_LT(median(with), 0.05);
  EXPECT_GT(median(without), 1.2 * median(with)) << "the middle of a patch decides where it is, labels or not";
}

/// Errors of the strips' features in a second frame, px.
std::vector<double> tracking_errors(bool with_labels) {
  Fence fence;
  const Image labels = fence.labels();
  Harness harness(dense(), kWidth, kHeight);
  std::map<std::uint32_t, Feature> born =
      testing::by_id(harness.process(fence.render(1), with_labels ? labels.view() : LabelView{}));
  fence.strip_shift_px = 2.4;
  fence.wall_shift_px = -1.3;
  std::vector<double> errors;
  for (const Feature& feature : harness.track(fence.render(2))) {
    const Feature& before = born[feature.id];
    if (Fence{}.on_strip(double{before.left_px.x()})) {
      const Vector2d truth = before.left_px.cast<double>() + Vector2d(fence.strip_shift_px, 0.0);
      errors.push_back((feature.left_px.cast<double>() - truth).norm());
    }
  }
  return errors;
}

TEST(Contours, NarrowThingsAreFollowedOnTheirOwn) {
  const std::vector<double> with = tracking_errors(true);
  const std::vector<double> without = tracking_errors(false);
  EXPECT_GT(with.size(), 60U);
  EXPECT_LT(median(with), 0.06);
  EXPECT_GT(median(without), 1.5 * median(with));
}

}  // namespace
}  // namespace kinetrace::features

// Left-right matching against exact disparities.
#include <cmath>

#include <gtest/gtest.h>

#include "front_end_harness.hpp"

namespace kinetrace::features {
namespace {

using Eigen::Vector2d;
using testing::Harness;
using testing::Image;
using testing::mean;
using testing::median;
using testing::Scene;
using testing::StereoImage;
using testing::Texture;

Scene textured(const Texture& texture) {
  Scene scene;
  scene.noise_gray = 2.0;
  scene.disparity.centre = {160.0, 120.0};
  scene.left = [&texture](const Vector2d& p) { return texture(p); };
  return scene;
}

/// Binomial filter of three columns.
void blur_columns(Image& image) {
  const MutableGrayView pixels = image.pixels();
  for (int y = 0; y < pixels.height; ++y) {
    int before = pixels.at(0, y);
    for (int x = 1; x + 1 < pixels.width; ++x) {
      const int here = pixels.at(x, y);
      pixels.at(x, y) = static_cast<std::uint8_t>((before + 2 * here + pixels.at(x + 1, y) + 2) / 4);
      before = here;
    }
  }
}

/// Disparity errors of freshly born features.
struct Matches {
  int features = 0;
  std::vector<double> errors_px;
  std::vector<double> row_errors_px;  ///< v_px against the mean of the rows.
  int bad = 0;

  [[nodiscard]] double share() const { return static_cast<double>(errors_px.size()) / features; }
};

Matches match(const Scene& scene, const StereoImage& images, const FeatureConfig& config = {}) {
  Harness harness(config, scene.width, scene.height);
  Matches matches;
  for (const Feature& feature : harness.process(images)) {
    // Further left the right patch would not be in the image.
    if (feature.left_px.x() < scene.disparity.at_centre + 40.0) {
      continue;
    }
    ++matches.features;
    if (!feature.has_right()) {
      EXPECT_EQ(feature.v_px, feature.left_px.y());
      continue;
    }
    matches.errors_px.push_back(feature.disparity_px() - scene.disparity(feature.left_px.cast<double>()));
    matches.row_errors_px.push_back(feature.v_px - (feature.left_px.y() + 0.5 * scene.row_offset_px));
    matches.bad += std::abs(matches.errors_px.back()) > 1.0;
  }
  return matches;
}

Matches match(const Scene& scene, const FeatureConfig& config = {}) {
  return match(scene, scene.render(), config);
}

TEST(StereoMatching, IsUnbiasedOverAllSubPixelPhases) {
  const Texture texture(1);
  std::vector<double> all_px;
  for (int phase = 0; phase < 8; ++phase) {
    Scene scene = textured(texture);
    scene.disparity.at_centre = 20.0 + phase / 8.0;
    const Matches matches = match(scene);
    EXPECT_GT(matches.share(), 0.9) << phase;
    EXPECT_LE(matches.bad, 1) << phase;
    std::vector<double> good_px;
    std::copy_if(matches.errors_px.begin(), matches.errors_px.end(), std::back_inserter(good_px),
                 [](double e) { return std::abs(e) <= 1.0; });
    EXPECT_LE(std::abs(mean(good_px)), 0.025) << "pixel locking at phase " << phase;
    all_px.insert(all_px.end(), good_px.begin(), good_px.end());
  }
  EXPECT_LE(std::abs(mean(all_px)), 0.005);
}

TEST(StereoMatching, BlurOfOneImageDoesNotShiftMatches) {
  const auto mean_error_px = [](bool blurs_left) {
    std::vector<double> errors_px;
    for (unsigned seed = 1; seed <= 12; ++seed) {
      const Texture texture(seed, 35.0, 3.0);
      Scene scene = textured(texture);
      scene.disparity.at_centre = 20.0 + seed / 8.0;
      StereoImage images = scene.render(seed);
      blur_columns(blurs_left ? images.left : images.right);
      const Matches matches = match(scene, images);
      std::copy_if(matches.errors_px.begin(), matches.errors_px.end(), std::back_inserter(errors_px),
                   [](double e) { return std::abs(e) <= 1.0; });
    }
    return mean(errors_px);
  };
  EXPECT_NEAR(mean_error_px(true), mean_error_px(false), 0.005) << "0.014 with all patches on one side of their corner";
}

TEST(StereoMatching, FollowsTheSlantOfASurface) {
  const Texture texture(2);
  Scene scene = textured(texture);
  scene.disparity.at_centre = 60.3;
  scene.disparity.gradient = {0.08, 0.3};  // A road: 0.3 px of disparity a row.
  const Matches matches = match(scene);
  EXPECT_GT(matches.share(), 0.8);
  EXPECT_LE(matches.bad, static_cast<int>(matches.errors_px.size()) * 3 / 100);
  std::vector<double> sizes_px;
  for (const double error : matches.errors_px) {
    sizes_px.push_back(std::abs(error));
  }
  EXPECT_LE(median(sizes_px), 0.05) << "without the slant it would be 0.2";
  EXPECT_LE(std::abs(median(matches.errors_px)), 0.01);
}

TEST(StereoMatching, KeepsMatchesUnderGainAndOffset) {
  const Texture texture(3);
  Scene scene = textured(texture);
  scene.disparity.at_centre = 31.4;
  scene.right_gain = 0.75;
  scene.right_offset = 20.0;
  const Matches matches = match(scene);
  EXPECT_GT(matches.share(), 0.85);
  EXPECT_LE(matches.bad, 2);
  EXPECT_LE(std::abs(mean(matches.errors_px)), 0.02);
}

TEST(StereoMatching, TakesTheMeanRowOfThePair) {
  const Texture texture(4);
  for (const double rows_px : {-0.6, 0.7, 2.5}) {
    Scene scene = textured(texture);
    scene.row_offset_px = rows_px;
    const Matches matches = match(scene);
    EXPECT_GT(matches.share(), 0.7) << rows_px;
    EXPECT_LE(std::abs(median(matches.row_errors_px)), 0.03) << rows_px;
    EXPECT_LE(std::abs(median(matches.errors_px)), 0.03) << rows_px;
  }
}

TEST(StereoMatching, RejectsPairsMoreThanThreePixelsApart) {
  const Texture texture(5);
  Scene scene = textured(texture);
  scene.row_offset_px = 4.0;
  EXPECT_LE(match(scene).share(), 0.05);
}

TEST(StereoMatching, ReachesTheLargestDisparityAndNotBeyond) {
  const Texture texture(6);
  FeatureConfig config;
  config.max_disparity_px = 64;
  Scene scene = textured(texture);
  scene.disparity.at_centre = 63.5;
  EXPECT_GT(match(scene, config).share(), 0.9);
  // Another place may look similar by chance; most features must report no match.
  scene.disparity.at_centre = 80.0;
  EXPECT_LE(match(scene, config).share(), 0.15);
}

TEST(StereoMatching, KeepsFarPointsAndRejectsNegativeDisparities) {
  const Texture texture(7);
  Scene scene = textured(texture);
  scene.disparity.at_centre = 0.8;
  EXPECT_GT(match(scene).share(), 0.9);
  scene.disparity.at_centre = 0.2;
  EXPECT_LE(match(scene).share(), 0.05);
  scene.disparity.at_centre = -1.0;
  EXPECT_LE(match(scene).share(), 0.02);
}

TEST(StereoMatching, DoesNotTrustRepetitiveTexture) {
  // Repeats every 12.6 px: between whole pixels, so that no two repetitions cost exactly the same.
  Scene scene;
  scene.left = [](const Vector2d& p) { return 128.0 + 50.0 * std::cos(p.x() * 0.5) + 40.0 * std::cos(p.y() * 0.4); };
  for (const double noise_gray : {0.5, 3.0}) {
    scene.noise_gray = noise_gray;
    EXPECT_LE(match(scene).share(), 0.1) << noise_gray;
  }
}

TEST(StereoMatching, FollowsTrackedFeaturesFromFrameToFrame) {
  const Texture texture(8);
  Harness harness({}, 320, 240);
  Scene scene = textured(texture);
  scene.disparity.at_centre = 40.0;
  harness.process(scene.render(1));
  scene.disparity.at_centre = 43.2;
  int matched = 0;
  std::vector<double> errors_px;
  for (const Feature& feature : harness.track(scene.render(2))) {
    if (feature.had_right() && feature.has_right()) {
      ++matched;
      errors_px.push_back(std::abs(feature.disparity_px() - 43.2));
      EXPECT_NEAR(feature.previous_left_px.x() - feature.previous_u_right_px, 40.0F, 1.5F);
    }
  }
  EXPECT_GT(matched, 50);
  EXPECT_LE(median(errors_px), 0.05);
}

}  // namespace
}  // namespace kinetrace::features

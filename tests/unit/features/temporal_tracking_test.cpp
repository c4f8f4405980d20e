// Tracking against exact motions of an exact texture.
#include <algorithm>
#include <cmath>
#include <random>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "front_end_harness.hpp"

namespace kinetrace::features {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using testing::by_id;
using testing::Harness;
using testing::median;
using testing::Scene;
using testing::Texture;

/// Maps pixels of the first image to a later one: affine, about the centre.
struct Motion {
  Matrix2d matrix = Matrix2d::Identity();
  Vector2d shift = Vector2d::Zero();
  Vector2d centre = Vector2d::Zero();

  [[nodiscard]] Vector2d forward(const Vector2d& p) const { return matrix * (p - centre) + centre + shift; }
  [[nodiscard]] Vector2d backward(const Vector2d& p) const { return matrix.inverse() * (p - centre - shift) + centre; }
};

Matrix2d rotation(double degrees) {
  const double angle = degrees * 3.14159265358979 / 180.0;
  Matrix2d m;
  m << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  return m;
}

/// Result of two frames of a moving texture.
struct Outcome {
  int trackable = 0;  ///< Features whose patch is still in the image.
  int tracked = 0;
  int bad = 0;  ///< Off by more than a pixel.
  std::vector<double> errors_px;
  FeatureCounters counters;

  [[nodiscard]] double tracked_share() const { return static_cast<double>(tracked) / trackable; }
  [[nodiscard]] double bad_share() const { return static_cast<double>(bad) / tracked; }
};

enum class Prediction { kNone, kOff };

struct Experiment {
  int width = 480;
  int height = 320;
  Motion motion;
  Prediction prediction = Prediction::kNone;
  double prediction_error_px = 0.0;  ///< In a random direction for each feature.
  double gain = 1.0;
  double offset_gray = 0.0;
  double noise_gray = 2.0;
  FeatureConfig config;

  [[nodiscard]] Outcome run() const {
    const Texture texture(11);
    Motion m = motion;
    m.centre = {0.5 * width, 0.5 * height};
    Scene before;
    before.width = width;
    before.height = height;
    before.noise_gray = noise_gray;
    before.left = [&](const Vector2d& p) { return texture(p); };
    Scene after = before;
    const double zoom = std::sqrt(m.matrix.determinant());
    after.disparity.at_centre *= zoom;
    after.left = [&](const Vector2d& p) { return gain * (texture(m.backward(p)) - 128.0) + 128.0 + offset_gray; };

    Harness harness(config, width, height);
    const auto born = by_id(harness.process(before.render(1)));
    EXPECT_GT(born.size(), 100U);

    std::mt19937 random(7);
    std::uniform_real_distribution<double> angle(0.0, 6.283);
    std::vector<FeaturePrediction> predictions(static_cast<std::size_t>(config.max_features));
    Outcome outcome;
    for (const auto& [id, feature] : born) {
      const Vector2d truth = m.forward(feature.left_px.cast<double>());
      outcome.trackable += truth.x() > 12 && truth.y() > 10 && truth.x() < width - 13 && truth.y() < height - 11;
      const double direction = angle(random);
      const Vector2d error = prediction_error_px * Vector2d(std::cos(direction), std::sin(direction));
      predictions[feature.slot].left_px = (truth + error).cast<float>();
      predictions[feature.slot].known = prediction == Prediction::kOff;
      predictions[feature.slot].disparity_px = static_cast<float>(zoom * before.disparity.at_centre);
    }
    for (const Feature& feature : harness.track(after.render(2), predictions)) {
      const Vector2d truth = m.forward(born.at(feature.id).left_px.cast<double>());
      outcome.errors_px.push_back((feature.left_px.cast<double>() - truth).norm());
      outcome.bad += outcome.errors_px.back() > 1.0;
      EXPECT_EQ(feature.age_frames, 1U);
      EXPECT_EQ(feature.previous_left_px, born.at(feature.id).left_px);
      EXPECT_EQ(feature.slot, born.at(feature.id).slot);
    }
    outcome.tracked = static_cast<int>(outcome.errors_px.size());
    outcome.counters = harness->counters();
    return outcome;
  }
};

void expect_accurate(const Outcome& outcome, double median_px = 0.1) {
  EXPECT_GT(outcome.tracked_share(), 0.9);
  EXPECT_LE(outcome.bad_share(), 0.03);
  EXPECT_LE(median(outcome.errors_px), median_px);
}

TEST(TemporalTracking, FollowsASubPixelShift) {
  Experiment experiment;
  experiment.motion.shift = {3.37, -1.81};
  expect_accurate(experiment.run(), 0.05);
}

TEST(TemporalTracking, FollowsSixtyPixelsWithoutPrediction) {
  Experiment experiment;
  experiment.motion.shift = {55.3, 20.6};
  expect_accurate(experiment.run());
}

TEST(TemporalTracking, FollowsAHundredPixelsFromAPredictionTenPixelsOff) {
  Experiment experiment;
  experiment.width = 640;
  experiment.motion.shift = {100.4, 30.7};
  experiment.prediction = Prediction::kOff;
  experiment.prediction_error_px = 10.0;
  expect_accurate(experiment.run());
}

TEST(TemporalTracking, SurvivesWildlyWrongPredictionsByASecondStart) {
  for (const double error_px : {80.0, 3000.0}) {
    Experiment experiment;
    experiment.motion.shift = {10.2, 3.3};
    experiment.prediction = Prediction::kOff;
    experiment.prediction_error_px = error_px;
    const Outcome outcome = experiment.run();
    EXPECT_GT(outcome.tracked_share(), 0.9) << error_px;
    EXPECT_LE(outcome.bad_share(), 0.12) << error_px;
    EXPECT_LE(median(outcome.errors_px), 0.1) << error_px;
    EXPECT_GT(outcome.counters.recovered, static_cast<std::uint64_t>(outcome.tracked) * 3 / 4) << error_px;
  }
}

TEST(TemporalTracking, IgnoresPredictionsThatAreNotNumbers) {
  Experiment experiment;
  experiment.motion.shift = {2.2, 1.3};
  experiment.prediction = Prediction::kOff;
  experiment.prediction_error_px = std::nan("");
  expect_accurate(experiment.run());
}

TEST(TemporalTracking, FollowsTenPercentZoom) {
  Experiment experiment;
  experiment.motion.matrix = 1.1 * Matrix2d::Identity();
  expect_accurate(experiment.run());
}

TEST(TemporalTracking, FollowsFortyPercentZoomOfAnOncomingCarWhenPredicted) {
  Experiment experiment;
  experiment.motion.matrix = 1.4 * Matrix2d::Identity();
  experiment.prediction = Prediction::kOff;
  experiment.prediction_error_px = 3.0;
  expect_accurate(experiment.run());
}

TEST(TemporalTracking, FollowsFiveDegreesOfRotation) {
  Experiment experiment;
  experiment.motion.matrix = rotation(5.0);
  expect_accurate(experiment.run());
}

TEST(TemporalTracking, IsBlindToGainAndOffset) {
  Experiment experiment;
  experiment.motion.shift = {4.4, 2.7};
  experiment.gain = 0.7;
  experiment.offset_gray = 25.0;
  expect_accurate(experiment.run());
}

TEST(TemporalTracking, WorksOnAnImageTooSmallForItsPyramid) {
  Experiment experiment;
  experiment.width = 200;
  experiment.height = 120;
  experiment.config.pyramid_levels = 1;
  experiment.config.bucket_px = 10;
  experiment.motion.shift = {2.5, -1.5};
  expect_accurate(experiment.run());
}

/// Median error against the place where each feature was born, of features `age` frames old, in a sequence.
std::map<std::uint32_t, double> drift_of(bool against_reference, double zoom_per_frame, std::uint32_t frames) {
  constexpr int kWidth = 400;
  constexpr int kHeight = 280;
  FeatureConfig config;
  config.refine_against_reference = against_reference;
  Harness harness(config, kWidth, kHeight);
  const Texture texture(7);
  std::map<std::uint32_t, Vector2d> born_at;
  std::map<std::uint32_t, std::vector<double>> errors_px;
  for (std::uint32_t i = 0; i <= frames; ++i) {
    const double scale = std::pow(zoom_per_frame, i);
    Motion motion;
    motion.matrix = scale * Matrix2d::Identity();
    motion.shift = Vector2d(1.3, 0.7) * i;
    motion.centre = {0.5 * kWidth, 0.5 * kHeight};
    Scene scene;
    scene.width = kWidth;
    scene.height = kHeight;
    scene.noise_gray = 2.0;
    scene.disparity.at_centre = 12.0 * scale;
    scene.left = [&](const Vector2d& p) { return texture(motion.backward(p)); };
    for (const Feature& feature : harness.process(scene.render(i + 1))) {
      const Vector2d world = motion.backward(feature.left_px.cast<double>());
      if (feature.age_frames == 0) {
        born_at[feature.id] = world;
      } else {
        errors_px[feature.age_frames].push_back((world - born_at.at(feature.id)).norm() * scale);
      }
    }
  }
  std::map<std::uint32_t, double> medians_px;
  for (const auto& [age, values] : errors_px) {
    medians_px[age] = median(values);
  }
  return medians_px;
}

TEST(TemporalTracking, DoesNotDriftUnderTranslation) {
  const auto error_px = drift_of(true, 1.0, 12);
  EXPECT_LE(error_px.at(1), 0.05);
  EXPECT_LE(error_px.at(12), 0.05);
}

TEST(TemporalTracking, ReferencePatchBoundsDriftUnderSlowZoom) {
  const auto with_px = drift_of(true, 1.03, 12);
  const auto without_px = drift_of(false, 1.03, 12);
  EXPECT_LE(with_px.at(1), 0.05);
  EXPECT_LE(with_px.at(12), 0.08);
  EXPECT_LE(with_px.at(12), 0.2 * without_px.at(12)) << "the reference patch is worth its cost";
}

TEST(TemporalTracking, EndsFeaturesThatAreOccluded) {
  const Texture texture(2);
  const Texture cover(91);
  Scene scene;
  scene.left = [&](const Vector2d& p) { return texture(p); };
  Scene covered = scene;
  const auto is_covered = [](const Vector2d& p) { return p.x() > 120 && p.x() < 220; };
  covered.left = [&](const Vector2d& p) { return is_covered(p) ? cover(p) : texture(p); };

  Harness harness({}, scene.width, scene.height);
  const auto born = harness.process(scene.render());
  std::vector<FeaturePrediction> predictions(static_cast<std::size_t>(FeatureConfig{}.max_features));
  for (const Feature& feature : born) {
    predictions[feature.slot] = {feature.left_px, -1.F, true};
  }
  const auto alive = by_id(harness.track(covered.render(), predictions));
  int hidden = 0;
  int hidden_alive = 0;
  int open = 0;
  int open_alive = 0;
  for (const Feature& feature : born) {
    const double x = feature.left_px.x();
    const bool lives = alive.contains(feature.id);
    if (x > 132 && x < 208) {
      ++hidden;
      hidden_alive += lives;
    } else if (x < 108 || x > 232) {
      ++open;
      open_alive += lives;
    }
  }
  EXPECT_GT(hidden, 20);
  EXPECT_LE(hidden_alive, hidden / 10);
  EXPECT_GT(open_alive, open * 9 / 10);
  EXPECT_GT(harness->counters().lost_residual + harness->counters().lost_forward_backward, 20U);
}

TEST(TemporalTracking, EndsFeaturesThatLeaveTheImage) {
  const Texture texture(4);
  Scene scene;
  scene.left = [&](const Vector2d& p) { return texture(p); };
  Scene moved = scene;
  moved.left = [&](const Vector2d& p) { return texture(p - Vector2d(30.0, 0.0)); };
  Harness harness({}, scene.width, scene.height);
  harness.process(scene.render());
  for (const Feature& feature : harness.track(moved.render())) {
    EXPECT_GE(feature.left_px.x(), 7.5F);
    EXPECT_LE(feature.left_px.x(), static_cast<float>(scene.width) - 8.5F);
  }
  EXPECT_GT(harness->counters().lost(), 0U);
}

TEST(TemporalTracking, HasNothingToTrackWithoutTexture) {
  Scene scene;
  scene.left = [](const Vector2d&) { return 90.0; };
  Harness harness({}, scene.width, scene.height);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(harness.process(scene.render()).empty());
  }
  EXPECT_EQ(harness->counters().created, 0U);
}

TEST(TemporalTracking, EndsEverythingWhenTextureDisappears) {
  const Texture texture(4);
  Scene scene;
  scene.left = [&](const Vector2d& p) { return texture(p); };
  Scene blank = scene;
  blank.left = [](const Vector2d&) { return 0.0; };
  Harness harness({}, scene.width, scene.height);
  EXPECT_GT(harness.process(scene.render()).size(), 50U);
  EXPECT_TRUE(harness.track(blank.render()).empty());
}

}  // namespace
}  // namespace kinetrace::features

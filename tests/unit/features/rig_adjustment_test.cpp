// Correction of the right image for its camera's true pose, and unknown row offsets.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "front_end_harness.hpp"
#include "kinetrace/core/rig_correction.hpp"

namespace kinetrace::features {
namespace {

using Eigen::Vector2d;
using testing::Harness;
using testing::Scene;
using testing::Texture;

constexpr double kFocal_px = 500.0;

Scene textured(const Texture& texture) {
  Scene scene;
  scene.noise_gray = 1.0;
  scene.disparity.centre = {160.0, 120.0};
  scene.disparity.at_centre = 20.0;
  scene.left = [&texture](const Vector2d& p) { return texture(p); };
  return scene;
}

StereoGeometry geometry_of(const Scene& scene) {
  return {.fx_px = kFocal_px,
          .fy_px = kFocal_px,
          .cx_px = 0.5 * scene.width,
          .cy_px = 0.5 * scene.height,
          .baseline_m = 0.2,
          .width_px = scene.width,
          .height_px = scene.height};
}

class Adjusted {
 public:
  explicit Adjusted(const Scene& scene) : scene_(scene), harness_({}, scene.width, scene.height) {}

  std::vector<Feature> process(const RigAdjustment& rig) {
    const testing::StereoImage images = scene_.render();
    RectifiedPair pair = images.pair(next_++);
    pair.geometry = geometry_of(scene_);
    EXPECT_TRUE((*harness_).begin_frame(pair, rig));
    EXPECT_TRUE(harness_->track({}));
    const Result<FeatureFrame> frame = harness_->replenish({});
    EXPECT_TRUE(frame);
    return {frame->features.begin(), frame->features.end()};
  }

 private:
  Scene scene_;
  Harness harness_;
  std::int64_t next_ = 0;
};

double share_matched(const std::vector<Feature>& features) {
  const auto matched = std::count_if(features.begin(), features.end(), [](const Feature& f) { return f.has_right(); });
  return static_cast<double>(matched) / static_cast<double>(features.size());
}

double median_disparity_error_px(const Scene& scene, const std::vector<Feature>& features) {
  std::vector<double> errors;
  for (const Feature& f : features) {
    if (f.has_right()) {
      errors.push_back(f.disparity_px() - scene.disparity(f.left_px.cast<double>()));
    }
  }
  return testing::median(errors);
}

TEST(RigAdjustment, AShiftedPrincipalPointLeavesDisparitiesAsTheyAre) {
  const Texture texture(3);
  Adjusted adjusted(textured(texture));
  // The image is as calibrated, so that any correction appears as an equal error.
  for (const double shift_px : {0.0, 1.0, 0.4, -0.7}) {
    RigAdjustment rig;
    rig.correction.shift_rad = shift_px / kFocal_px;
    const std::vector<Feature> features = adjusted.process(rig);
    EXPECT_GT(share_matched(features), 0.8) << shift_px;
    EXPECT_NEAR(median_disparity_error_px(textured(texture), features), -shift_px, 0.03) << shift_px;
  }
}

TEST(RigAdjustment, ATurnOfThePitchBringsRowsBack) {
  const Texture texture(4);
  Scene scene = textured(texture);
  scene.row_offset_px = 2.0;
  RigAdjustment rig;
  rig.correction.turn_rad.x() = std::atan(scene.row_offset_px / kFocal_px);
  Adjusted adjusted(scene);
  std::vector<double> rows_px;
  for (const Feature& f : adjusted.process(rig)) {
    if (f.has_right()) {
      rows_px.push_back(2.0 * static_cast<double>(f.v_px - f.left_px.y()));
    }
  }
  EXPECT_LT(std::abs(testing::median(rows_px)), 0.05);
}

TEST(RigAdjustment, RowsFarOffAreFoundWhereTheCalibrationMayBeWrong) {
  const Texture texture(5);
  Scene scene = textured(texture);
  scene.row_offset_px = 6.0;
  Adjusted trusting(scene);
  Adjusted uncertain(scene);
  for (int i = 0; i < 3; ++i) {
    static_cast<void>(trusting.process({}));
    static_cast<void>(uncertain.process({.correction = {}, .may_be_off = true}));
  }
  EXPECT_LT(share_matched(trusting.process({})), 0.3);
  EXPECT_GT(share_matched(uncertain.process({.correction = {}, .may_be_off = true})), 0.7);
}

TEST(RigAdjustment, WhereMatchesLieNearTheLimitOthersAreLookedForBeyondIt) {
  const Texture texture(5);
  Scene scene = textured(texture);
  scene.row_offset_px = 2.95;  // Half of the matches lie beyond the limit of 3 px.
  Adjusted trusting(scene);
  Adjusted uncertain(scene);
  for (int i = 0; i < 3; ++i) {
    static_cast<void>(trusting.process({}));
    static_cast<void>(uncertain.process({.correction = {}, .may_be_off = true}));
  }
  EXPECT_LT(share_matched(trusting.process({})), 0.7);
  EXPECT_GT(share_matched(uncertain.process({.correction = {}, .may_be_off = true})), 0.8);
}

TEST(RigAdjustment, WhatWasMeasuredFollowsARevision) {
  const Texture texture(6);
  const Scene scene = textured(texture);
  Adjusted adjusted(scene);
  const std::vector<Feature> before = adjusted.process({});
  RigAdjustment rig;
  rig.correction.shift_rad = 0.5 / kFocal_px;
  const RigChange change(geometry_of(scene), {}, rig.correction);
  rig.change = &change;
  int seen = 0;
  const auto known = testing::by_id(before);
  for (const Feature& f : adjusted.process(rig)) {
    const auto was = known.find(f.id);
    if (was != known.end() && was->second.has_right() && f.had_right()) {
      EXPECT_NEAR(f.previous_u_right_px, was->second.u_right_px + 0.5F, 1e-3F);
      ++seen;
    }
  }
  EXPECT_GT(seen, 20);
}

}  // namespace
}  // namespace kinetrace::features

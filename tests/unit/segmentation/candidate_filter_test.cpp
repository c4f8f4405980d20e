#include "kinetrace/segmentation/candidate_filter.hpp"

#include <cstdint>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "kinetrace/core/detections.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr StereoGeometry kGeometry{
    .fx_px = 100.0, .fy_px = 100.0, .cx_px = 50.0, .cy_px = 50.0, .baseline_m = 0.5, .width_px = 100, .height_px = 100};
constexpr std::size_t kCapacity = 20;
/// 5 m away: a person of 2.5 m has a diagonal of 50 pixels.
constexpr float kDisparity_px = 10.F;

class CandidateFilterTest : public ::testing::Test {
 protected:
  CandidateFilterTest() {
    const auto carve = [&](Arena& arena) {
      seen_ = SeenFeatures(kCapacity, arena);
      filter_ = CandidateFilter(kGeometry, kCapacity, arena);
    };
    arena_ = std::make_unique<Arena>(measure_bytes(carve));
    carve(*arena_);
  }
  void add_feature(float x, float y, float disparity_px = kDisparity_px) {
    Feature feature;
    feature.id = static_cast<std::uint32_t>(features_.size() + 1);
    feature.slot = static_cast<std::uint16_t>(features_.size());
    feature.left_px = {x, y};
    feature.u_right_px = x - disparity_px;
    features_.push_back(feature);
  }
  void add_features(int count, float x, float y, float disparity_px = kDisparity_px) {
    for (int i = 0; i < count; ++i) {
      add_feature(x, y + static_cast<float>(i), disparity_px);
    }
  }
  /// Number of accepted ones.
  std::size_t accepted(std::vector<RunLengthMask> candidates) {
    seen_.remember(features_);
    const std::span<const RunLengthMask> plausible = filter_.plausible(candidates, seen_.by_slot());
    accepted_.assign(plausible.begin(), plausible.end());
    return accepted_.size();
  }

  std::unique_ptr<Arena> arena_;
  SeenFeatures seen_;
  CandidateFilter filter_;
  std::vector<Feature> features_;
  std::vector<RunLengthMask> accepted_;
  // Filled boxes.
  std::vector<std::uint16_t> small_runs_{0, 20 * 36};
  std::vector<std::uint16_t> large_runs_{0, 20 * 60};
  RunLengthMask small_{kPedestrianClass, 0.9F, {10, 10, 30, 46}, small_runs_};
  RunLengthMask large_{kPedestrianClass, 0.8F, {40, 10, 60, 70}, large_runs_};
};

TEST_F(CandidateFilterTest, RejectsAPersonLargerThanAny) {
  add_features(5, 20.F, 20.F);
  add_features(5, 50.F, 20.F);
  ASSERT_EQ(accepted({small_, large_}), 1U);
  EXPECT_EQ(accepted_[0].score, small_.score);
}

TEST_F(CandidateFilterTest, AcceptsOneThatIsNearer) {
  add_features(5, 50.F, 20.F, 1.5F * kDisparity_px);
  EXPECT_EQ(accepted({large_}), 1U);
}

TEST_F(CandidateFilterTest, AcceptsLargeObjectsOfOtherClasses) {
  add_features(5, 50.F, 20.F);
  large_.class_id = kVehicleClass;
  EXPECT_EQ(accepted({large_}), 1U);
}

TEST_F(CandidateFilterTest, AcceptsWhatHasNoDisparity) {
  EXPECT_EQ(accepted({large_}), 1U);
  add_features(3, 50.F, 20.F);
  EXPECT_EQ(accepted({large_}), 1U) << "three features may be wrong";
  add_feature(50.F, 40.F);
  features_.back().u_right_px = kNoRight;
  EXPECT_EQ(accepted({large_}), 1U) << "one without a right match does not count";
}

TEST_F(CandidateFilterTest, FeaturesBehindThePersonDoNotMakeItLarger) {
  add_features(4, 50.F, 20.F, 0.3F * kDisparity_px);
  add_features(4, 55.F, 20.F, 1.5F * kDisparity_px);
  EXPECT_EQ(accepted({large_}), 1U);
}

TEST_F(CandidateFilterTest, OnlyFeaturesInTheMaskCount) {
  // The left half of the box alone.
  std::vector<std::uint16_t> runs{0};
  for (int row = 0; row < 60; ++row) {
    runs.push_back(10);
    runs.push_back(10);
  }
  large_.runs = runs;
  add_features(8, 50.F, 20.F);
  EXPECT_EQ(accepted({large_}), 1U);
  add_features(4, 49.F, 66.F);
  EXPECT_EQ(accepted({large_}), 0U);
}

TEST_F(CandidateFilterTest, ForgetsTheFrameBefore) {
  add_features(5, 50.F, 20.F);
  EXPECT_EQ(accepted({large_}), 0U);
  features_.clear();
  EXPECT_EQ(accepted({large_}), 1U);
}

}  // namespace
}  // namespace kinetrace::segmentation

// A front end with its arena, and the few calls every test makes.
#pragma once

#include <cmath>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/features/feature_front_end.hpp"
#include "synthetic_scene.hpp"

namespace kinetrace::features::testing {

class Harness {
 public:
  Harness(const FeatureConfig& config, int width, int height, Workers* workers = nullptr)
      : arena_(FeatureFrontEnd::required_bytes(config, width, height)),
        front_end_(create(config, width, height, workers)) {}

  FeatureFrontEnd& operator*() { return front_end_; }
  FeatureFrontEnd* operator->() { return &front_end_; }

  /// A whole frame; returns the features alive at its end.
  std::vector<Feature> process(const StereoImage& images, LabelView labels = {},
                               std::span<const FeaturePrediction> by_slot = {}) {
    track(images, by_slot);
    return replenish(labels);
  }
  std::vector<Feature> track(const StereoImage& images, std::span<const FeaturePrediction> by_slot = {}) {
    EXPECT_TRUE(front_end_.begin_frame(images.pair(next_index_++)));
    return copied(front_end_.track(by_slot));
  }
  std::vector<Feature> replenish(LabelView labels = {}) { return copied(front_end_.replenish(labels)); }

 private:
  FeatureFrontEnd create(const FeatureConfig& config, int width, int height, Workers* workers) {
    Result<FeatureFrontEnd> created = FeatureFrontEnd::create(config, width, height, arena_, workers);
    EXPECT_TRUE(created) << created.error().message;
    return std::move(created.value());
  }
  static std::vector<Feature> copied(const Result<FeatureFrame>& frame) {
    EXPECT_TRUE(frame) << frame.error().message;
    return {frame->features.begin(), frame->features.end()};
  }

  Arena arena_;
  FeatureFrontEnd front_end_;
  std::int64_t next_index_ = 0;
};

inline std::map<std::uint32_t, Feature> by_id(const std::vector<Feature>& features) {
  std::map<std::uint32_t, Feature> result;
  for (const Feature& feature : features) {
    result[feature.id] = feature;
  }
  return result;
}

/// Median of a copy.
inline double median(std::vector<double> values) {
  EXPECT_FALSE(values.empty());
  if (values.empty()) {
    return NAN;
  }
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

inline double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) {
    sum += value;
  }
  return sum / static_cast<double>(values.size());
}

}  // namespace kinetrace::features::testing

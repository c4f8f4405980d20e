#include "kinetrace/recording/latency_histogram.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::recording {
namespace {

TEST(LatencyHistogram, IsAllZeroWithoutSamples) {
  const LatencyHistogram histogram;
  EXPECT_EQ(histogram.count(), 0U);
  EXPECT_EQ(histogram.quantile_ns(0.5), 0);
  EXPECT_EQ(histogram.summary().max_ms, 0.0);
}

TEST(LatencyHistogram, GivesOneSampleBackExactly) {
  LatencyHistogram histogram;
  histogram.add(12'345'678);
  const TimingSummary summary = histogram.summary();
  EXPECT_EQ(summary.count, 1U);
  EXPECT_DOUBLE_EQ(summary.median_ms, 12.345678);
  EXPECT_DOUBLE_EQ(summary.p95_ms, 12.345678);
  EXPECT_DOUBLE_EQ(summary.max_ms, 12.345678);
}

TEST(LatencyHistogram, CountsShortDurationsExactly) {
  LatencyHistogram histogram;
  for (int ns = 0; ns <= 255; ++ns) {
    histogram.add(ns);
  }
  EXPECT_EQ(histogram.min_ns(), 0);
  EXPECT_EQ(histogram.quantile_ns(0.5), 127);
  EXPECT_EQ(histogram.quantile_ns(0.0), 0);
  EXPECT_EQ(histogram.quantile_ns(1.0), 255);
}

TEST(LatencyHistogram, QuantilesAreWithinOnePercentOverEightDecades) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(1.0, 9.5);
  LatencyHistogram histogram;
  std::vector<std::int64_t> samples;
  for (int i = 0; i < 20000; ++i) {
    samples.push_back(static_cast<std::int64_t>(std::pow(10.0, exponent(random))));
    histogram.add(samples.back());
  }
  std::sort(samples.begin(), samples.end());
  for (const double q : {0.01, 0.25, 0.5, 0.9, 0.95, 0.99, 0.9999}) {
    const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(samples.size()))) - 1;
    const auto truth = static_cast<double>(samples[rank]);
    EXPECT_NEAR(static_cast<double>(histogram.quantile_ns(q)), truth, 0.004 * truth + 0.5) << q;
  }
  EXPECT_EQ(histogram.max_ns(), samples.back());
  EXPECT_EQ(histogram.min_ns(), samples.front());
}

TEST(LatencyHistogram, FindsThe95thPercentileOfTwoGroups) {
  LatencyHistogram histogram;
  for (int i = 0; i < 100; ++i) {
    histogram.add(i < 95 ? 1'000'000 : 9'000'000);
  }
  EXPECT_NEAR(histogram.summary().p95_ms, 1.0, 0.004);
  histogram.add(9'000'000);
  EXPECT_NEAR(histogram.summary().p95_ms, 9.0, 0.036);
}

TEST(LatencyHistogram, TakesNegativeAndHugeDurations) {
  LatencyHistogram histogram;
  histogram.add(-5);
  histogram.add(INT64_MAX);
  EXPECT_EQ(histogram.min_ns(), 0);
  EXPECT_EQ(histogram.max_ns(), INT64_MAX);
  EXPECT_GE(histogram.quantile_ns(1.0), std::int64_t{1} << 35);
}

TEST(LatencyHistogram, ForgetsOnReset) {
  LatencyHistogram histogram;
  histogram.add(1000);
  histogram.reset();
  EXPECT_EQ(histogram.count(), 0U);
  EXPECT_EQ(histogram.max_ns(), 0);
}

}  // namespace
}  // namespace kinetrace::recording

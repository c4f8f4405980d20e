// Quantiles of durations in fixed memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "kinetrace/core/export.hpp"

namespace kinetrace::recording {

/// Times of one stage.
struct TimingSummary {
  std::uint64_t count = 0;
  double median_ms = 0.0;
  double p95_ms = 0.0;
  double max_ms = 0.0;  ///< Exact.
};

/// Latency from exposure to result.
struct LatencySummary {
  std::uint64_t count = 0;
  double p50_ms = 0.0;
  double p95_ms = 0.0;
  double p99_ms = 0.0;
  double max_ms = 0.0;  ///< Exact.
};

/// A log-linear histogram: below 2^8 ns each nanosecond has its own bucket, above that every octave has 128. A quantile
/// is off by less than 0.4 % (half a bucket); minimum and maximum are exact. Durations above 2^36 ns (69 s) share the
/// last bucket. Takes 15 KiB, never allocates, adds in constant time.
class KINETRACE_API LatencyHistogram {
 public:
  void add(std::int64_t duration_ns) noexcept;  ///< A negative duration (a clock set back) counts as zero.
  void reset() noexcept { *this = LatencyHistogram{}; }

  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  [[nodiscard]] std::int64_t min_ns() const noexcept { return count_ == 0 ? 0 : min_ns_; }
  [[nodiscard]] std::int64_t max_ns() const noexcept { return max_ns_; }
  /// The smallest duration that is not exceeded by a fraction `q` in [0, 1] of the samples; 0 without samples.
  [[nodiscard]] std::int64_t quantile_ns(double q) const noexcept;
  [[nodiscard]] TimingSummary summary() const noexcept;
  [[nodiscard]] LatencySummary quantiles() const noexcept;

 private:
  static constexpr int kBucketBits = 7;
  static constexpr int kMaxBits = 36;
  static constexpr std::size_t kBucketCount = static_cast<std::size_t>(kMaxBits - kBucketBits + 1) << kBucketBits;

  [[nodiscard]] static std::size_t bucket_of(std::int64_t duration_ns) noexcept;
  [[nodiscard]] static std::int64_t centre_of(std::size_t bucket) noexcept;

  std::array<std::uint32_t, kBucketCount> buckets_{};
  std::uint64_t count_ = 0;
  std::int64_t min_ns_ = 0;
  std::int64_t max_ns_ = 0;
};

}  // namespace kinetrace::recording

#include "kinetrace/recording/latency_histogram.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace kinetrace::recording {

std::size_t LatencyHistogram::bucket_of(std::int64_t duration_ns) noexcept {
  const auto value =
      static_cast<std::uint64_t>(std::clamp<std::int64_t>(duration_ns, 0, (std::int64_t{1} << kMaxBits) - 1));
  // Keep the leading kBucketBits + 1 bits of the value; `shift` counts the octaves above the linear part.
  const int shift = std::max(0, static_cast<int>(std::bit_width(value)) - kBucketBits - 1);
  return (static_cast<std::size_t>(shift) << kBucketBits) + static_cast<std::size_t>(value >> shift);
}

std::int64_t LatencyHistogram::centre_of(std::size_t bucket) noexcept {
  constexpr std::size_t kLinear = std::size_t{2} << kBucketBits;  // Buckets one nanosecond wide.
  if (bucket < kLinear) {
    return static_cast<std::int64_t>(bucket);
  }
  const std::size_t shift = (bucket >> kBucketBits) - 1;
  const std::size_t leading = bucket - (shift << kBucketBits);
  return static_cast<std::int64_t>((leading << shift) + (std::size_t{1} << shift) / 2);
}

void LatencyHistogram::add(std::int64_t duration_ns) noexcept {
  const std::int64_t duration = std::max<std::int64_t>(duration_ns, 0);
  ++buckets_[bucket_of(duration)];
  min_ns_ = count_ == 0 ? duration : std::min(min_ns_, duration);
  max_ns_ = std::max(max_ns_, duration);
  ++count_;
}

std::int64_t LatencyHistogram::quantile_ns(double q) const noexcept {
  if (count_ == 0) {
    return 0;
  }
  const double rank = std::ceil(std::clamp(q, 0.0, 1.0) * static_cast<double>(count_));
  const auto wanted = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(rank));
  std::uint64_t seen = 0;
  for (std::size_t bucket = 0; bucket < kBucketCount; ++bucket) {
    seen += buckets_[bucket];
    if (seen >= wanted) {
      return std::clamp(centre_of(bucket), min_ns_, max_ns_);
    }
  }
  return max_ns_;
}

TimingSummary LatencyHistogram::summary() const noexcept {
  constexpr double kMsPerNs = 1e-6;
  return {.count = count_,
          .median_ms = static_cast<double>(quantile_ns(0.5)) * kMsPerNs,
          .p95_ms = static_cast<double>(quantile_ns(0.95)) * kMsPerNs,
          .max_ms = static_cast<double>(max_ns_) * kMsPerNs};
}

LatencySummary LatencyHistogram::quantiles() const noexcept {
  const auto quantile_ms = [this](double q) {
    constexpr double kMsPerNs = 1e-6;
    return static_cast<double>(q < 1.0 ? quantile_ns(q) : max_ns_) * kMsPerNs;
  };
  return {.count = count_,
          .p50_ms = quantile_ms(0.5),
          .p95_ms = quantile_ms(0.95),
          .p99_ms = quantile_ms(0.99),
          .max_ms = quantile_ms(1.0)};
}

}  // namespace kinetrace::recording

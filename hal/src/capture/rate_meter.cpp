#include "capture/rate_meter.hpp"

#include "kinetrace/core/quantiles.hpp"

namespace kinetrace::hal {

std::optional<double> RateMeter::add(std::int64_t sequence, std::int64_t stamp_ns) noexcept {
  if (count_ == kSteps) {
    return std::nullopt;
  }
  if (sequence_ && sequence > *sequence_) {
    periods_ns_[count_++] = (stamp_ns - stamp_ns_) / (sequence - *sequence_);
  }
  sequence_ = sequence;
  stamp_ns_ = stamp_ns;
  if (count_ < kSteps) {
    return std::nullopt;
  }
  const std::int64_t period_ns = median(periods_ns_);
  return period_ns > 0 ? std::optional(1e9 / static_cast<double>(period_ns)) : std::nullopt;
}

}  // namespace kinetrace::hal

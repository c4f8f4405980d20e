#include "capture/rate_meter.hpp"

#include <algorithm>

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
  const auto middle = periods_ns_.begin() + kSteps / 2;
  std::nth_element(periods_ns_.begin(), middle, periods_ns_.end());
  return *middle > 0 ? std::optional(1e9 / static_cast<double>(*middle)) : std::nullopt;
}

}  // namespace kinetrace::hal

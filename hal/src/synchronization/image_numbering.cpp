#include "synchronization/image_numbering.hpp"

#include <algorithm>
#include <utility>

namespace kinetrace::hal {

std::int64_t ImageNumbering::next(std::optional<std::int64_t> sequence, std::optional<std::int64_t> time_ns) noexcept {
  const auto before = std::exchange(sequence_, sequence);
  if (sequence && before) {
    number_ += std::max<std::int64_t>(1, *sequence - *before);
  } else if (time_ns && timed_) {
    // Ignores images without a time in between: an additional one must not shift the following numbers.
    const std::int64_t periods = (*time_ns - timed_->time_ns + period_ns_ / 2) / period_ns_;
    number_ = timed_->number + std::max<std::int64_t>(1, periods);
  } else {
    ++number_;
  }
  if (time_ns) {
    timed_ = {number_, *time_ns};
  }
  return number_;
}

}  // namespace kinetrace::hal

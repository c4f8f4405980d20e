// The remaining time of a call.
#pragma once

#include <algorithm>
#include <chrono>

namespace kinetrace::hal {

/// Expires `timeout` after construction.
class Deadline {
 public:
  explicit Deadline(std::chrono::milliseconds timeout) : end_(Clock::now() + timeout) {}

  /// Remaining time, rounded up so that one wait is enough; zero after expiry.
  [[nodiscard]] std::chrono::milliseconds left() const {
    return std::max(std::chrono::ceil<std::chrono::milliseconds>(end_ - Clock::now()), std::chrono::milliseconds(0));
  }
  [[nodiscard]] bool is_over() const { return Clock::now() >= end_; }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point end_;
};

}  // namespace kinetrace::hal

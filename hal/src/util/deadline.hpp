// How long a call may still take.
#pragma once

#include <algorithm>
#include <chrono>

namespace kinetrace::hal {

/// `timeout` from its making on.
class Deadline {
 public:
  explicit Deadline(std::chrono::milliseconds timeout) : end_(Clock::now() + timeout) {}

  /// Rounded up, so that waiting for it is enough; zero once it is over.
  [[nodiscard]] std::chrono::milliseconds left() const {
    return std::max(std::chrono::ceil<std::chrono::milliseconds>(end_ - Clock::now()), std::chrono::milliseconds(0));
  }
  [[nodiscard]] bool is_over() const { return Clock::now() >= end_; }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point end_;
};

}  // namespace kinetrace::hal

// The system's clocks as integers.
#pragma once

#include <chrono>
#include <cstdint>

namespace kinetrace::app {

/// Monotonic: for durations and deadlines.
[[nodiscard]] inline std::int64_t steady_time_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}
/// Unix time, comparable between machines.
[[nodiscard]] inline std::int64_t system_time_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace kinetrace::app

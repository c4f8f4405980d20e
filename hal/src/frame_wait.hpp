// Waiting for a device.
#pragma once

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <poll.h>

namespace kinetrace::hal {

/// True once the descriptor is readable or in error, false after the timeout.
inline bool wait_readable(int fd, std::chrono::milliseconds timeout) noexcept {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point deadline = Clock::now() + timeout;
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    pollfd file{fd, POLLIN, 0};
    const int ready = poll(&file, 1, static_cast<int>(std::max<std::chrono::milliseconds::rep>(left.count(), 0)));
    if (ready >= 0 || errno != EINTR) {
      return ready > 0;
    }
  }
}

}  // namespace kinetrace::hal

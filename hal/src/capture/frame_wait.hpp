// Waiting for a device.
#pragma once

#include <cerrno>
#include <chrono>
#include <poll.h>

#include "util/deadline.hpp"

namespace kinetrace::hal {

/// True once the descriptor is readable or in error, false after the timeout.
inline bool wait_readable(int fd, std::chrono::milliseconds timeout) noexcept {
  const Deadline deadline(timeout);
  for (;;) {
    pollfd file{fd, POLLIN, 0};
    const int ready = poll(&file, 1, static_cast<int>(deadline.left().count()));
    if (ready >= 0 || errno != EINTR) {
      return ready > 0;
    }
  }
}

}  // namespace kinetrace::hal

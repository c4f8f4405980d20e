// Time stamps of an unknown clock.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace kinetrace::hal {

/// One moment in two clocks, which differ by the time that the machine was suspended.
struct ClockReading {
  std::int64_t monotonic_ns = 0;
  std::int64_t boottime_ns = 0;
};

/// libcamera stamps in CLOCK_BOOTTIME, but passes on the drivers' stamps of CLOCK_MONOTONIC. A stamp is recent: its
/// clock is the one in which it is nearer to `now`. Returned in CLOCK_MONOTONIC.
[[nodiscard]] inline std::int64_t to_monotonic_ns(std::int64_t stamp_ns, const ClockReading& now) noexcept {
  const bool is_boottime = std::abs(now.boottime_ns - stamp_ns) < std::abs(now.monotonic_ns - stamp_ns);
  return is_boottime ? stamp_ns - (now.boottime_ns - now.monotonic_ns) : stamp_ns;
}

}  // namespace kinetrace::hal

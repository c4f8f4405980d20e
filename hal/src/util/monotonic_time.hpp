// Time stamps of unknown clock.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace kinetrace::hal {

/// The same moment in two clocks, which differ by the time the machine has slept.
struct ClockReading {
  std::int64_t monotonic_ns = 0;
  std::int64_t boottime_ns = 0;
};

/// libcamera stamps in CLOCK_BOOTTIME, but hands through what drivers stamp in CLOCK_MONOTONIC. A stamp is of the
/// recent past: of the two clocks it belongs to the one in which it is nearer to `now`. Returned in CLOCK_MONOTONIC.
[[nodiscard]] inline std::int64_t to_monotonic_ns(std::int64_t stamp_ns, const ClockReading& now) noexcept {
  const bool is_boottime = std::abs(now.boottime_ns - stamp_ns) < std::abs(now.monotonic_ns - stamp_ns);
  return is_boottime ? stamp_ns - (now.boottime_ns - now.monotonic_ns) : stamp_ns;
}

}  // namespace kinetrace::hal

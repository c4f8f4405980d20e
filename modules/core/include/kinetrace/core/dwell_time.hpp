// Duration of a state that is observed at frames only.
#pragma once

#include <cmath>
#include <cstdint>

namespace kinetrace {

/// Assumed frame interval (10 Hz) until a second frame shows the rate of the camera.
inline constexpr std::int64_t kUsualInterval_ns = 100'000'000;

/// A setting in seconds, in the unit of time stamps.
[[nodiscard]] inline std::int64_t to_ns(double seconds) noexcept {
  return std::llround(1e9 * seconds);
}

/// Dwell time of a state. The first frame in a state shows that the state began since the frame before: halfway, on
/// average. So n frames are n - 1/2 intervals, and a limit of whole intervals lies half an interval from the nearest
/// frames: jitter of the time stamps does not change which frame exceeds it. Jitter is handled nowhere else.
class DwellTime {
 public:
  /// One more frame in the state, `interval_ns` after the frame before it.
  void add_frame(std::int64_t interval_ns) noexcept { ns_ += ns_ == 0 ? interval_ns / 2 : interval_ns; }
  void reset() noexcept { ns_ = 0; }
  [[nodiscard]] std::int64_t ns() const noexcept { return ns_; }
  [[nodiscard]] bool exceeds(std::int64_t limit_ns) const noexcept { return ns_ > limit_ns; }

 private:
  std::int64_t ns_ = 0;
};

}  // namespace kinetrace

// How long a state lasts that is seen at frames only.
#pragma once

#include <cmath>
#include <cstdint>

namespace kinetrace {

/// Until a second frame tells the rate of the camera, frames are taken to come at 10 Hz.
inline constexpr std::int64_t kUsualInterval_ns = 100'000'000;

/// A setting in seconds as it is compared with time stamps.
[[nodiscard]] inline std::int64_t to_ns(double seconds) noexcept {
  return std::llround(1e9 * seconds);
}

/// Dwell time of a state. The first frame in a state shows that it was entered since the frame before: halfway, on
/// average. So n frames are n - 1/2 intervals, and a limit of whole intervals lies half an interval from the frames on
/// either side of it: the same frame exceeds it however the time stamps jitter. This is the only place for that.
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

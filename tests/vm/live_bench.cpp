#include "live_bench.hpp"

namespace kinetrace::hal::test {

LiveCameraConfig live_config(const CaptureConfig& left, const std::optional<CaptureConfig>& right) {
  constexpr double kHalfPeriod_ms = 500.0;
  LiveCameraConfig config;
  config.left = left;
  config.right = right;
  config.pair_tolerance_ms = kHalfPeriod_ms / left.rate_hz;
  config.stall_timeout_ms = 2000.0;
  config.lost_timeout_ms = 4000.0;
  return config;
}

}  // namespace kinetrace::hal::test

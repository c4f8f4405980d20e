// Measures the rate of a device that does not report it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace kinetrace::hal {

/// Measures once, over the first images of a stream. Robust to lost images and to a few late stamps.
class RateMeter {
 public:
  /// The stream begins.
  void reset() noexcept { *this = {}; }
  /// Call it for every image. Returns the rate in Hz once, at the image that completes the measurement.
  [[nodiscard]] std::optional<double> add(std::int64_t sequence, std::int64_t stamp_ns) noexcept;

 private:
  static constexpr std::size_t kSteps = 31;

  std::array<std::int64_t, kSteps> periods_ns_{};
  std::size_t count_ = 0;
  std::optional<std::int64_t> sequence_;
  std::int64_t stamp_ns_ = 0;
};

}  // namespace kinetrace::hal

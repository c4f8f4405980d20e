// Budget of bytes to send, with priorities.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace kinetrace::publishing {

/// Priorities. Each class leaves a reserve for the more important ones until the budget has grown again.
enum class Priority : std::uint8_t {
  kEssential,     ///< Poses, objects, health, calibration: may use the whole budget.
  kTrajectories,  ///< Leaves a quarter.
  kDrawings,      ///< Markers; leaves 3/8.
  kPoints,        ///< Leaves half.
};

/// A token bucket: it grows by bytes_per_second up to a quarter of a second's worth, but at least to four pieces, so
/// that a piece of points always fits into its half.
class ByteBudget {
 public:
  /// Full at first.
  ByteBudget(int bytes_per_second, int piece_bytes) noexcept
      : bytes_per_second_(bytes_per_second),
        capacity_(std::max(bytes_per_second / 4.0, kPiecesHeld * piece_bytes)),
        allowance_(capacity_) {}

  /// Grows the budget. `now_ns` is a steady clock.
  void refill(std::int64_t now_ns) noexcept {
    constexpr double kSecond_ns = 1e9;
    const std::int64_t elapsed_ns = now_ns - last_ns_.value_or(now_ns);
    allowance_ = std::min(capacity_, allowance_ + static_cast<double>(elapsed_ns) / kSecond_ns * bytes_per_second_);
    last_ns_ = now_ns;
  }

  /// Takes `bytes` and returns true if they may be sent now.
  [[nodiscard]] bool take(std::size_t bytes, Priority priority) noexcept {
    constexpr std::array<double, 4> kLeft{0.0, 0.25, 0.375, 0.5};
    const double rest = allowance_ - static_cast<double>(bytes);
    if (rest < kLeft[static_cast<std::size_t>(priority)] * capacity_) {
      return false;
    }
    allowance_ = rest;
    return true;
  }

  /// Charges bytes that are sent unconditionally.
  void charge(std::size_t bytes) noexcept { allowance_ -= static_cast<double>(bytes); }

 private:
  static constexpr double kPiecesHeld = 4.0;
  double bytes_per_second_;
  double capacity_;
  double allowance_;
  std::optional<std::int64_t> last_ns_{};
};

}  // namespace kinetrace::publishing

// How many bytes may be sent, and whose turn it is when there are not enough.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace kinetrace::publishing {

/// What is sent first when not everything can be. Each class leaves untouched what the more important ones may need
/// before the allowance has grown again.
enum class Priority : std::uint8_t {
  kEssential,     ///< Poses, objects, health, calibration: may use all that is there.
  kTrajectories,  ///< Leaves a quarter.
  kDrawings,      ///< Markers; leaves 3/8.
  kPoints,        ///< Leaves half.
};

/// A token bucket: it grows by bytes_per_second and holds a quarter of a second's worth, but always enough that a piece
/// of points fits into its half.
class ByteBudget {
 public:
  /// Full at first.
  ByteBudget(int bytes_per_second, int piece_bytes) noexcept
      : bytes_per_second_(bytes_per_second),
        capacity_(std::max(bytes_per_second / 4.0, kPiecesHeld * piece_bytes)),
        allowance_(capacity_) {}

  /// Lets the allowance grow. `now_ns` is a steady clock.
  void refill(std::int64_t now_ns) noexcept {
    constexpr double kSecond_ns = 1e9;
    const std::int64_t elapsed_ns = now_ns - last_ns_.value_or(now_ns);
    allowance_ = std::min(capacity_, allowance_ + static_cast<double>(elapsed_ns) / kSecond_ns * bytes_per_second_);
    last_ns_ = now_ns;
  }

  /// True, and taken, if `bytes` may be sent now.
  [[nodiscard]] bool take(std::size_t bytes, Priority priority) noexcept {
    constexpr std::array<double, 4> kLeft{0.0, 0.25, 0.375, 0.5};
    const double rest = allowance_ - static_cast<double>(bytes);
    if (rest < kLeft[static_cast<std::size_t>(priority)] * capacity_) {
      return false;
    }
    allowance_ = rest;
    return true;
  }

  /// What is sent whether it may or not.
  void charge(std::size_t bytes) noexcept { allowance_ -= static_cast<double>(bytes); }

 private:
  static constexpr double kPiecesHeld = 4.0;
  double bytes_per_second_;
  double capacity_;
  double allowance_;
  std::optional<std::int64_t> last_ns_{};
};

}  // namespace kinetrace::publishing

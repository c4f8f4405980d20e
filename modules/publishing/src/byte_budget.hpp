// How many bytes may be sent, and whose turn it is when there are not enough.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

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
  ByteBudget(int bytes_per_second, int piece_bytes) noexcept
      : bytes_per_second_(bytes_per_second), capacity_(std::max(bytes_per_second / 4.0, kPiecesHeld * piece_bytes)) {}

  /// Lets the allowance grow. `now_ns` is a steady clock; the first call fills it.
  void refill(std::int64_t now_ns) noexcept {
    constexpr double kSecond_ns = 1e9;
    allowance_ =
        !started_
            ? capacity_
            : std::min(capacity_, allowance_ + static_cast<double>(now_ns - last_ns_) / kSecond_ns * bytes_per_second_);
    started_ = true;
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

 private:
  static constexpr double kPiecesHeld = 4.0;
  double bytes_per_second_;
  double capacity_;
  double allowance_ = 0.0;
  bool started_ = false;
  std::int64_t last_ns_ = 0;
};

}  // namespace kinetrace::publishing

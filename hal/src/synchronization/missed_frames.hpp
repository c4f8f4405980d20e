// Counts frames without an image of either view.
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>

#include "kinetrace/hal/frame_synchronizer.hpp"

namespace kinetrace::hal {

/// Counts the image numbers (ImageNumbering) since the last delivered pair for which neither view had an image. A loss
/// of one view alone leaves the other's image without a partner and is not counted here. Never allocates.
class MissedFrames {
 public:
  /// Nothing counts before the next pair: the camera was stopped or lost.
  void restart() noexcept { begun_ = false; }
  /// Call it for every image, used or not.
  void see(View view, std::int64_t number) noexcept;
  /// Call it for every delivered pair. Returns the number of missed frames since the last one.
  std::uint64_t deliver(std::int64_t left_number, std::int64_t right_number) noexcept;

 private:
  /// Number of frames for which one view may stall while the other continues.
  static constexpr std::size_t kWindow = 256;

  [[nodiscard]] std::int64_t place_of(View view, std::int64_t number) const noexcept {
    return number - base_[static_cast<std::size_t>(view)];
  }
  void advance(std::int64_t places) noexcept;

  bool begun_ = false;
  std::array<std::int64_t, 2> base_{};  ///< Numbers of place 0, by view.
  std::bitset<kWindow> seen_;           ///< Bit i: an image of place i + 1.
  std::uint64_t missed_ = 0;
};

}  // namespace kinetrace::hal

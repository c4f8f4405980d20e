// How many frames neither view had an image of.
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>

#include "kinetrace/hal/frame_synchronizer.hpp"

namespace kinetrace::hal {

/// Counts from pair to pair: numbers of images (ImageNumbering) since the last pair that was delivered, of which no
/// image came from either view. What one view alone lost shows as the other's image without a partner and is not
/// counted here. Never allocates.
class MissedFrames {
 public:
  /// Nothing is counted before the next pair: the camera was away.
  void restart() noexcept { begun_ = false; }
  /// An image came, whatever became of it.
  void see(View view, std::int64_t number) noexcept;
  /// A pair of these images is delivered. Returns how many frames were missed before it, since the last one.
  std::uint64_t deliver(std::int64_t left_number, std::int64_t right_number) noexcept;

 private:
  /// A view may be silent for so many frames while the other goes on.
  static constexpr std::size_t kWindow = 256;

  [[nodiscard]] std::int64_t place_of(View view, std::int64_t number) const noexcept {
    return number - base_[static_cast<std::size_t>(view)];
  }
  void advance(std::int64_t places) noexcept;

  bool begun_ = false;
  std::array<std::int64_t, 2> base_{};  ///< Numbers of place 0, by view.
  std::bitset<kWindow> seen_;           ///< Bit i: place i + 1.
  std::uint64_t missed_ = 0;
};

}  // namespace kinetrace::hal

#include "synchronization/missed_frames.hpp"

#include <algorithm>
#include <utility>

namespace kinetrace::hal {

// Moves the window by `places`; those without an image are missed.
void MissedFrames::advance(std::int64_t places) noexcept {
  const auto left_behind = static_cast<std::size_t>(places);
  const std::bitset<kWindow> kept = left_behind < kWindow ? seen_ >> left_behind : std::bitset<kWindow>();
  missed_ += left_behind - (seen_.count() - kept.count());
  seen_ = kept;
  for (std::int64_t& number : base_) {
    number += places;
  }
}

void MissedFrames::see(View view, std::int64_t number) noexcept {
  if (!begun_ || place_of(view, number) < 1) {
    return;
  }
  const auto window = static_cast<std::int64_t>(kWindow);
  if (const std::int64_t beyond = place_of(view, number) - window; beyond > 0) {
    advance(beyond);
  }
  seen_.set(static_cast<std::size_t>(place_of(view, number) - 1));
}

std::uint64_t MissedFrames::deliver(std::int64_t left_number, std::int64_t right_number) noexcept {
  if (begun_) {
    see(View::kLeft, left_number);
    see(View::kRight, right_number);
    advance(std::max<std::int64_t>({place_of(View::kLeft, left_number), place_of(View::kRight, right_number), 0}));
  } else {
    seen_.reset();
    missed_ = 0;
  }
  begun_ = true;
  base_ = {left_number, right_number};
  return std::exchange(missed_, 0);
}

}  // namespace kinetrace::hal

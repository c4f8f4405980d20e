// Keys of earlier versions that are still accepted.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

namespace kinetrace::app {

/// Where both keys exist, the old one counts frames at 10 Hz, the new one seconds.
struct RenamedKey {
  std::string_view was;
  std::string_view is;  ///< Empty: the key is ignored.
};

inline constexpr double kFramesPerSecond = 10.0;

inline constexpr std::array<RenamedKey, 8> kRenamedKeys{{
    {"segmentation.motion.hold_frames", "segmentation.motion.hold_s"},
    {"segmentation.motion.window_frames", "segmentation.motion.memory_s"},
    {"tracking.max_missed_frames", "tracking.max_missed_s"},
    {"tracking.max_unseen_frames", "tracking.max_unseen_s"},
    {"tracking.max_tentative_missed_frames", "tracking.max_tentative_missed_s"},
    {"object.lost_after_frames", "object.lost_after_s"},
    {"trajectory.box_percentile", ""},
    {"trajectory.min_box_size_m", ""},
}};

/// The current name of `key`.
[[nodiscard]] constexpr std::string_view present_key(std::string_view key) noexcept {
  const auto* const renamed =
      std::find_if(kRenamedKeys.begin(), kRenamedKeys.end(), [key](const RenamedKey& k) { return k.was == key; });
  return renamed == kRenamedKeys.end() ? key : renamed->is;
}

}  // namespace kinetrace::app

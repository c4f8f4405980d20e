// Keys of earlier versions that are still accepted.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

namespace kinetrace::app {

struct RenamedKey {
  std::string_view was;
  std::string_view is;          ///< Empty: the key is ignored.
  bool counted_frames = false;  ///< At 10 Hz; the new key is in seconds.
};

inline constexpr double kFramesPerSecond = 10.0;

inline constexpr std::array<RenamedKey, 16> kRenamedKeys{{
    {"segmentation.motion.hold_frames", "segmentation.motion.hold_s", true},
    {"segmentation.motion.window_frames", "segmentation.motion.memory_s", true},
    {"tracking.max_missed_frames", "tracking.max_missed_s", true},
    {"tracking.max_unseen_frames", "tracking.max_unseen_s", true},
    {"tracking.max_tentative_missed_frames", "tracking.max_tentative_missed_s", true},
    {"object.lost_after_frames", "object.lost_after_s", true},
    {"trajectory.velocity_window_frames", "trajectory.velocity_window_s", true},
    {"trajectory.max_acceleration_mps2", "trajectory.acceleration_mps2"},
    {"trajectory.smoothing_acceleration_mps2", ""},
    {"trajectory.smoothing_turn_radps2", "trajectory.turn_radps2"},
    {"trajectory.box_percentile", ""},
    {"trajectory.min_box_size_m", ""},
    {"patience.stall_ms", "timeouts.stall_ms"},
    {"patience.lost_ms", "timeouts.lost_ms"},
    {"patience.reopen_first_ms", "timeouts.reopen_first_ms"},
    {"patience.reopen_longest_ms", "timeouts.reopen_longest_ms"},
}};

/// Null if `key` is none of them.
[[nodiscard]] constexpr const RenamedKey* renamed_key(std::string_view key) noexcept {
  const auto* const renamed =
      std::find_if(kRenamedKeys.begin(), kRenamedKeys.end(), [key](const RenamedKey& k) { return k.was == key; });
  return renamed == kRenamedKeys.end() ? nullptr : renamed;
}

/// The current name of `key`.
[[nodiscard]] constexpr std::string_view present_key(std::string_view key) noexcept {
  const RenamedKey* const renamed = renamed_key(key);
  return renamed == nullptr ? key : renamed->is;
}

}  // namespace kinetrace::app

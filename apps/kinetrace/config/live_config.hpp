// Settings of live mode.
#pragma once

#include <cstdint>
#include <string_view>

#include "kinetrace/core/result.hpp"

namespace kinetrace::app {

enum class LiveMode : std::uint8_t {
  kAuto,  ///< Devices live, recordings not.
  kOn,
  kOff,
};

[[nodiscard]] constexpr std::string_view to_string(LiveMode mode) noexcept {
  switch (mode) {
    case LiveMode::kAuto: return "auto";
    case LiveMode::kOn: return "on";
    case LiveMode::kOff: return "off";
  }
  return "off";
}
[[nodiscard]] bool from_string(std::string_view text, LiveMode& mode) noexcept;

struct LiveConfig {
  LiveMode mode = LiveMode::kAuto;
  double deadline_ms = 0.0;   ///< For processing a frame; 0: the time between frames.
  bool shed = true;           ///< Reduce the effort while deadlines are missed.
  double speed = 1.0;         ///< Playback speed of a recording, recorded time per real time.
  int realtime_priority = 0;  ///< SCHED_FIFO for the thread that captures; 0: as all others.

  /// Errors: kInvalidConfig.
  [[nodiscard]] Status validate() const;
};

template <typename Visitor>
void visit_fields(LiveConfig& config, Visitor&& visit) {
  visit("live.mode", config.mode,
        "auto (on for devices), on (the newest frame wins, others are left out) or off (every frame is processed)");
  visit("live.deadline_ms", config.deadline_ms, "time limit for processing a frame, ms; 0: the time between frames");
  visit("live.shed", config.shed,
        "load shedding while deadlines are missed: fewer refinement iterations, then points, then objects");
  visit("live.speed", config.speed,
        "speed of a recording that is played live, as a multiple of that at which it was taken");
  visit("live.realtime_priority", config.realtime_priority,
        "priority of the capture thread (SCHED_FIFO, 1 to 99), so that a busy board loses no image; 0: none");
}

}  // namespace kinetrace::app

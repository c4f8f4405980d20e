// The life of a track as a state machine: one table, pure, so that every transition can be tested by itself.
#pragma once

#include <cstdint>

#include "kinetrace/core/track_frame.hpp"

namespace kinetrace::tracking {

enum class LifeState : std::uint8_t {
  kFree,       ///< A slot without a track.
  kTentative,  ///< Born, not yet detected often enough to be confirmed.
  kConfirmed,  ///< Detected in this frame.
  kHidden,     ///< Not detected, and it cannot be expected to be: outside the image, or behind something.
  kMissing,    ///< Not detected where it should be in plain sight.
  kDormant,    ///< Missing for so long that what is detected there is something else: re-identification alone finds it.
  kEnded,      ///< In this frame.
};

/// What a frame says about a track. Clocks are dwell times since the last detection, true once they have run out.
struct LifeEvidence {
  bool detected = false;
  bool often_detected = false;    ///< In `confirm_frames` frames by now.
  bool in_plain_sight = false;    ///< A detection can be expected.
  bool placed = false;            ///< Where it is, or its direction, is predicted: worth waiting for.
  bool vanished = false;          ///< Nothing of its predicted mask is left.
  bool missed = false;            ///< Clock: for longer than `max_missed_s`.
  bool missed_in_sight = false;   ///< ... in plain sight.
  bool missed_tentative = false;  ///< Clock: for longer than `max_tentative_missed_s` where detections were looked for.
  bool forgotten = false;         ///< Clock: for longer than `max_unseen_s` beyond that.
  bool terminated = false;        ///< It has passed to another object.
};

/// The state after this frame. A free slot and an ended track stay what they are.
[[nodiscard]] LifeState next(LifeState state, const LifeEvidence& evidence) noexcept;

[[nodiscard]] constexpr bool is_alive(LifeState state) noexcept {
  return state != LifeState::kFree && state != LifeState::kEnded;
}

/// As it is published.
[[nodiscard]] constexpr TrackState track_state(LifeState state) noexcept {
  return state == LifeState::kTentative   ? TrackState::kTentative
         : state == LifeState::kConfirmed ? TrackState::kConfirmed
                                          : TrackState::kPropagated;
}

}  // namespace kinetrace::tracking

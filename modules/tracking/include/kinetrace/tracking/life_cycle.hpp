// The life of a track as a state machine: a pure function, so that each transition can be tested by itself.
#pragma once

#include <cstdint>

#include "kinetrace/core/track_frame.hpp"

namespace kinetrace::tracking {

enum class LifeState : std::uint8_t {
  kFree,       ///< A slot without a track.
  kTentative,  ///< Initiated, not yet confirmed.
  kConfirmed,  ///< Detected in this frame.
  kHidden,     ///< Not detected, and no detection expected: outside the image or occluded.
  kMissing,    ///< Not detected although in plain sight.
  kDormant,    ///< Missing too long: a detection there counts as another object; only re-identification revives it.
  kEnded,      ///< Ended in this frame.
};

/// Evidence of one frame about a track. Clocks are dwell times since the last detection, true once they have run out.
struct LifeEvidence {
  bool detected = false;
  bool often_detected = false;    ///< In `confirm_frames` frames by now.
  bool in_plain_sight = false;    ///< A detection is expected.
  bool has_prediction = false;    ///< Its position or direction is predicted, so that it may coast.
  bool vanished = false;          ///< Its predicted mask is smaller than `min_area_px`.
  bool missed = false;            ///< Clock: for longer than `max_missed_s`.
  bool missed_in_sight = false;   ///< ... in plain sight.
  bool missed_tentative = false;  ///< Clock: for longer than `max_tentative_missed_s` in frames searched for it.
  bool coasted_too_long = false;  ///< Clock: for longer than `max_missed_s` + `max_unseen_s`.
  bool terminated = false;        ///< It has switched to another object.
};

/// The state after this frame. Free slots and ended tracks do not change.
[[nodiscard]] LifeState next(LifeState state, const LifeEvidence& evidence) noexcept;

[[nodiscard]] constexpr bool is_alive(LifeState state) noexcept {
  return state != LifeState::kFree && state != LifeState::kEnded;
}

/// State as published.
[[nodiscard]] constexpr TrackState track_state(LifeState state) noexcept {
  return state == LifeState::kTentative   ? TrackState::kTentative
         : state == LifeState::kConfirmed ? TrackState::kConfirmed
                                          : TrackState::kPropagated;
}

}  // namespace kinetrace::tracking

// Tracked instance masks of one frame: the tracker state T of the paper, left and right.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace {

enum class TrackState : std::uint8_t {
  kTentative,   ///< Initiated, not yet confirmed.
  kConfirmed,   ///< Matched to a detection in this frame.
  kPropagated,  ///< Confirmed earlier, no detection in this frame: mask warped by the flow.
};

/// One object instance. The left track owns the identity; the right mask is attached to it.
struct Track {
  std::uint32_t id = 0;   ///< From 1, never reused in a run.
  std::uint8_t slot = 0;  ///< In [0, max_objects), reused after the track has ended. Its mask label is slot + 1.
  std::uint16_t class_id = 0;
  TrackState state = TrackState::kTentative;
  bool detected_moving = false;  ///< By its detection in this frame, see Detection::moving.
  bool mask_lost = false;   ///< Its predicted mask most likely lies beside it: missed for longer than chance explains.
  int age_frames = 0;       ///< Frames since birth.
  int missed_frames = 0;    ///< Frames since the last matched detection.
  std::int64_t age_ns = 0;  ///< Dwell time (see dwell_time.hpp) since birth,
  std::int64_t missed_ns = 0;  ///< ... and without a detection.
  float visible_part = 1.F;    ///< Fraction of the expected mask detected, in the image and unoccluded; both views.
  PixelBox box_px;             ///< Of the left mask; empty when outside the image.
  int area_px = 0;             ///< Of the left mask.

  [[nodiscard]] std::uint8_t label() const noexcept { return static_cast<std::uint8_t>(slot + 1); }
};

/// Tracker state of a frame; views live in the tracker until its next call.
struct TrackFrame {
  LabelView left_labels;          ///< Track::label() per pixel, kBackgroundLabel or kIgnoreLabel elsewhere.
  LabelView right_labels;         ///< The same in the right image.
  std::span<const Track> tracks;  ///< Alive, in ascending id, each id once.
  std::span<const Track> ended;   ///< Ended with this frame, with the last state they had.
};

}  // namespace kinetrace

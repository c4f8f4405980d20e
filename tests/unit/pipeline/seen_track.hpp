// A vehicle's track as the tracker makes it, for tests without a tracker.
#pragma once

#include <cstdint>

#include "kinetrace/core/track_frame.hpp"

namespace kinetrace::pipeline {

inline constexpr std::int64_t kFrame_ns = 100'000'000;

/// Detected at `box_px`, or not for so many frames.
inline Track seen_track(std::uint32_t id, std::uint8_t slot, const PixelBox& box_px, int missed_frames) {
  Track track;
  track.id = id;
  track.slot = slot;
  track.class_id = kVehicleClass;
  track.state = missed_frames > 0 ? TrackState::kPropagated : TrackState::kConfirmed;
  track.missed_frames = missed_frames;
  track.missed_ns = missed_frames > 0 ? missed_frames * kFrame_ns - kFrame_ns / 2 : 0;
  track.box_px = missed_frames > 0 ? PixelBox{} : box_px;
  track.area_px = track.box_px.width() * track.box_px.height();
  return track;
}

}  // namespace kinetrace::pipeline

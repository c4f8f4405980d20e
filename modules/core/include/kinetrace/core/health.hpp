// State of a running system, machine readable.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace kinetrace {

enum class HealthState : std::uint8_t {
  kOk,
  kDegraded,  ///< Results are produced, but an input is missing or was recently repaired.
  kLost,      ///< No results: the camera is gone.
};

[[nodiscard]] constexpr std::string_view to_string(HealthState state) noexcept {
  switch (state) {
    case HealthState::kOk: return "ok";
    case HealthState::kDegraded: return "degraded";
    case HealthState::kLost: return "lost";
  }
  return "lost";
}

enum class HealthReason : std::uint8_t {
  kCameraStalled,   ///< No image for longer than expected.
  kCameraLost,      ///< A device has gone.
  kFramesLost,      ///< Frames that never arrived, or with one view only.
  kFramesRepeated,  ///< Frames that arrived again or too late.
  kFramesDamaged,   ///< Unreadable or cut off.
  kFramesOfWrongSize,
  kFramesOutdated,    ///< Left out because processing could not follow.
  kClockJumped,       ///< Impossible time stamps, repaired.
  kViewsOutOfStep,    ///< Left and right are not from the same moment.
  kViewsIdentical,    ///< Left and right are the same image.
  kViewsExchanged,    ///< The left image is the right view's.
  kViewsUnrelated,    ///< Left and right show different things.
  kNoParallax,        ///< Left and right show no disparity.
  kCalibrationOff,    ///< The calibration does not fit the images.
  kImagesFrozen,      ///< A view delivers the same image again and again.
  kPoseLost,          ///< Frames in which the camera's own motion was not found.
  kRecordingStopped,  ///< Raw images are not recorded any more.
  kMasksMissing,      ///< Frames without the expected masks: a network is slow, fails, or is missing.
  kMasksUnreadable,   ///< Mask files that are damaged, or of another size or type.
  kMasksExchanged,    ///< The left masks are those of the right image.
  kMasksUnrelated,    ///< Masks of other images.
  kNotPublished,      ///< Results without receiver: network or DDS unavailable.
  // Reduced work after missed deadlines:
  kShedsIterations,  ///< Of bundle adjustment.
  kShedsPoints,
  kShedsObjects,
};
inline constexpr std::size_t kHealthReasonCount = 25;

[[nodiscard]] constexpr std::string_view to_string(HealthReason reason) noexcept {
  constexpr std::array<std::string_view, kHealthReasonCount> kNames{
      "camera_stalled",    "camera_lost",          "frames_lost",      "frames_repeated",
      "frames_damaged",    "frames_of_wrong_size", "frames_outdated",  "clock_jumped",
      "views_out_of_step", "views_identical",      "views_exchanged",  "views_unrelated",
      "no_parallax",       "calibration_off",      "images_frozen",    "pose_lost",
      "recording_stopped", "masks_missing",        "masks_unreadable", "masks_exchanged",
      "masks_unrelated",   "not_published",        "sheds_iterations", "sheds_points",
      "sheds_objects"};
  return kNames[static_cast<std::size_t>(reason)];
}

/// Count and frames of one kind of problem.
struct HealthEntry {
  HealthReason reason = HealthReason::kCameraStalled;
  std::uint64_t count = 0;
  std::int64_t first_frame = 0;  ///< Newest frame at its first occurrence...
  std::int64_t last_frame = 0;   ///< ...and at its last one.
};

}  // namespace kinetrace

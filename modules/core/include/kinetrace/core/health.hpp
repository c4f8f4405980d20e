// How well a running system is, in words that a machine can compare.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace kinetrace {

enum class HealthState : std::uint8_t {
  kOk,
  kDegraded,  ///< Results come, but something is missing or was mended lately.
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
  kCameraStalled,   ///< No image for longer than there should be.
  kCameraLost,      ///< A device has gone.
  kFramesLost,      ///< Frames that never came, or with one view only.
  kFramesRepeated,  ///< Frames that came again or too late.
  kFramesDamaged,   ///< Unreadable or cut off.
  kFramesOfWrongSize,
  kFramesOutdated,    ///< Left out because processing could not follow.
  kClockJumped,       ///< Times that could not be, mended.
  kViewsOutOfStep,    ///< Left and right are not from the same moment.
  kViewsIdentical,    ///< Left and right are the same image.
  kViewsExchanged,    ///< The left image is the right view's.
  kViewsUnrelated,    ///< Left and right show different things.
  kNoParallax,        ///< Left and right show no disparity.
  kCalibrationOff,    ///< The calibration does not fit the images.
  kImagesFrozen,      ///< A view delivers the same image again and again.
  kPoseLost,          ///< Frames in which the camera's own motion was not found.
  kRecordingStopped,  ///< Raw images are not recorded any more.
  kMasksMissing,      ///< Frames that were to have masks and had none: a network is slow, fails, or is not there.
  kMasksUnreadable,   ///< Mask files that are damaged, or of another size or type.
  kNotPublished,      ///< Results that reached nobody, since network or DDS were not there.
  // Frames for which less was done, since deadlines were missed:
  kShedsIterations,  ///< Of bundle adjustment.
  kShedsPoints,
  kShedsObjects,
};
inline constexpr std::size_t kHealthReasonCount = 23;

[[nodiscard]] constexpr std::string_view to_string(HealthReason reason) noexcept {
  constexpr std::array<std::string_view, kHealthReasonCount> kNames{
      "camera_stalled",    "camera_lost",          "frames_lost",      "frames_repeated",
      "frames_damaged",    "frames_of_wrong_size", "frames_outdated",  "clock_jumped",
      "views_out_of_step", "views_identical",      "views_exchanged",  "views_unrelated",
      "no_parallax",       "calibration_off",      "images_frozen",    "pose_lost",
      "recording_stopped", "masks_missing",        "masks_unreadable", "not_published",
      "sheds_iterations",  "sheds_points",         "sheds_objects"};
  return kNames[static_cast<std::size_t>(reason)];
}

/// How often something was wrong, and when.
struct HealthEntry {
  HealthReason reason = HealthReason::kCameraStalled;
  std::uint64_t count = 0;
  std::int64_t first_frame = 0;  ///< The newest frame when it was first noticed.
  std::int64_t last_frame = 0;   ///< ... and last.
};

}  // namespace kinetrace

// A first estimate, good enough for the bundle adjustment to find the rest.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "detector.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/hal/rig_calibration.hpp"
#include "lens.hpp"

namespace kinetrace::calibration {

/// The two poses that a plane may have for a nearly parallel view of it, the better one first (Collins and Bartoli,
/// "Infinitesimal plane-based pose estimation", IJCV 2014). Empty for fewer than four corners that a ray exists for.
[[nodiscard]] std::vector<Se3> plane_poses(const hal::CameraModel& camera, const Target& target,
                                           const std::vector<Corner>& corners);

/// RMS of the corners' distances from where this pose puts them.
[[nodiscard]] double reprojection_rms_px(const hal::CameraModel& camera, const Target& target, const Se3& T_cam_board,
                                         const std::vector<Corner>& corners);

/// A lens without distortion, its principal point in the middle, with the focal length that explains the views best.
/// None without a view.
[[nodiscard]] std::optional<hal::CameraModel> guess_camera(Lens lens, int width_px, int height_px, const Target& target,
                                                           std::span<const std::vector<Corner>> views);

/// Poses of the board in every view, and the right view's from the left one: that on which most views agree.
struct StereoGuess {
  Se3 T_right_left;
  std::vector<std::optional<Se3>> T_left_board;  ///< By view; none where it fits no pose.
};
[[nodiscard]] std::optional<StereoGuess> guess_poses(const hal::CameraModel& left, const hal::CameraModel& right,
                                                     const Target& target, std::span<const BoardView> views);

}  // namespace kinetrace::calibration

// Initial estimate, within the convergence range of the bundle adjustment.
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

/// The two possible poses of a plane in a nearly parallel view, the better one first (Collins and Bartoli,
/// "Infinitesimal plane-based pose estimation", IJCV 2014). Empty with fewer than four corners that have a ray.
[[nodiscard]] std::vector<Se3> plane_poses(const hal::CameraModel& camera, const Target& target,
                                           const std::vector<Corner>& corners);

/// RMS distance of the corners from their projections with this pose.
[[nodiscard]] double reprojection_rms_px(const hal::CameraModel& camera, const Target& target, const Se3& T_cam_board,
                                         const std::vector<Corner>& corners);

/// A lens without distortion, its principal point in the image centre, with the focal length that fits the views best.
/// None without a view.
[[nodiscard]] std::optional<hal::CameraModel> guess_camera(Lens lens, int width_px, int height_px, const Target& target,
                                                           std::span<const std::vector<Corner>> views);

/// Poses of the board in every view, and T_right_left as supported by most views.
struct StereoGuess {
  Se3 T_right_left;
  std::vector<std::optional<Se3>> T_left_board;  ///< By view; none if no pose fits.
};
[[nodiscard]] std::optional<StereoGuess> guess_poses(const hal::CameraModel& left, const hal::CameraModel& right,
                                                     const Target& target, std::span<const BoardView> views);

}  // namespace kinetrace::calibration

// Names of the native topics; those of ROS 2 are listed in the module's README.
#pragma once

namespace kinetrace::publishing::topics {

inline constexpr const char* kCameraPose = "kinetrace/camera_pose";
inline constexpr const char* kObjects = "kinetrace/objects";
inline constexpr const char* kTrajectories = "kinetrace/trajectories";
inline constexpr const char* kPoints = "kinetrace/points";
inline constexpr const char* kHealth = "kinetrace/health";
inline constexpr const char* kCalibration = "kinetrace/calibration";
inline constexpr const char* kMaskRequest = "kinetrace/mask_request";
inline constexpr const char* kInstanceMasks = "kinetrace/instance_masks";

}  // namespace kinetrace::publishing::topics

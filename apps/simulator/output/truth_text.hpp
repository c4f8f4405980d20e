// Lines of the text files beside a simulated sequence.
#pragma once

#include <cstdint>
#include <ostream>
#include <string>

#include "camera/camera_rig.hpp"
#include "rendering/stereo_simulator.hpp"

namespace kinetrace::simulator {

/// KITTI's calib_cam_to_cam.txt for cameras 00 and 01.
[[nodiscard]] std::string calibration_text(const CameraRig& rig);
/// KITTI raw's time stamps: date and time with nanoseconds, UTC.
[[nodiscard]] std::string timestamp_text(std::int64_t timestamp_ns);
/// KITTI odometry's poses: the upper three rows of T_world_cam.
void write_pose(const Se3& pose, std::ostream& out);

/// True pose error of the right camera, see RigErrors::RightCamera.
extern const char* const kRightCameraHeader;
void write_right_camera_row(const SimulatedFrame& frame, std::ostream& out);

extern const char* const kObjectsHeader;
void write_object_row(const SimulatedFrame& frame, const ObjectTruth& object, std::ostream& out);
/// KITTI tracking's label_02, for visible objects only.
void write_label(const SimulatedFrame& frame, const ObjectTruth& object, std::ostream& out);

}  // namespace kinetrace::simulator

// Calibration files that come with a plain folder pair. `size` is that of the images, for files that do not say.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/calibration_reader.hpp"
#include "calibration/yaml_document.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::hal {

/// All YAML files of a folder, sorted by name. The first that is damaged fails the whole: better than to miss it.
[[nodiscard]] Result<std::vector<YamlDocument>> load_yaml_files(const std::filesystem::path& folder);
/// The one calibration among the files; `root` is where they were looked for. Errors: kNotFound, kBadCalibration.
[[nodiscard]] Result<RigCalibration> read_yaml_calibration(const std::filesystem::path& root,
                                                           const std::vector<YamlDocument>& files,
                                                           const ImageSize& size);

/// OpenCV's stereo calibration, in one file or in two (intrinsics, extrinsics): K1 D1 K2 D2 R T, also spelled M1 or
/// cameraMatrix1 and so on; image_width and image_height, or imageSize. Rectification in the file is computed anew.
[[nodiscard]] bool is_opencv_stereo(const YamlDocument& file);
[[nodiscard]] Result<RigCalibration> read_opencv_stereo(const std::vector<YamlDocument>& files, const ImageSize& size);

/// Kalibr's camchain: cam0 left, cam1 right with T_cn_cnm1.
[[nodiscard]] bool is_kalibr_camchain(const YamlDocument& file);
[[nodiscard]] Result<RigCalibration> read_kalibr_camchain(const YamlDocument& file);

/// ROS CameraInfo of one view.
[[nodiscard]] bool is_ros_camera_info(const YamlDocument& file);
[[nodiscard]] Result<RigCalibration> read_ros_camera_infos(const YamlDocument& left, const YamlDocument& right);

/// Factory calibration of a ZED camera for images of this size. Errors: kBadCalibration.
[[nodiscard]] Result<RigCalibration> read_zed_calibration(const std::filesystem::path& path, std::string_view text,
                                                          const ImageSize& size);

/// What a DepthAI device holds, scaled to images of this size. Errors: kBadCalibration.
[[nodiscard]] bool is_depthai_calibration(std::string_view text);
[[nodiscard]] Result<RigCalibration> read_depthai_calibration(const std::filesystem::path& path, std::string_view text,
                                                              const ImageSize& size);

/// Puts 4, 5 or 8 coefficients into the camera as set_distortion does; what is wrong with them, without the key.
[[nodiscard]] std::optional<std::string> distortion_problem(CameraModel& camera,
                                                            const std::vector<double>& coefficients);

/// Puts 4, 5 or 8 coefficients (radial-tangential) or 4 (equidistant) into the camera; further ones must be zero.
[[nodiscard]] Status set_distortion(CameraModel& camera, const std::vector<double>& coefficients,
                                    const YamlDocument& file, std::string_view key);

}  // namespace kinetrace::hal

// Calibration files beside a plain pair of folders. `size`: of the images, for files without a size.
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

/// All YAML files of a folder, sorted by name. A damaged file fails the whole: it may be the calibration.
[[nodiscard]] Result<std::vector<YamlDocument>> load_yaml_files(const std::filesystem::path& folder);
/// The only calibration among the files; `root`: folder of the search, for messages. Errors: kNotFound,
/// kBadCalibration.
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

/// Calibration of a DepthAI device, scaled to images of this size. Errors: kBadCalibration.
[[nodiscard]] bool is_depthai_calibration(std::string_view text);
[[nodiscard]] Result<RigCalibration> read_depthai_calibration(const std::filesystem::path& path, std::string_view text,
                                                              const ImageSize& size);

/// Sets 4, 5 or 8 coefficients as set_distortion does. Returns the problem, without the key.
[[nodiscard]] std::optional<std::string> distortion_problem(CameraModel& camera,
                                                            const std::vector<double>& coefficients);

/// Sets 4, 5 or 8 coefficients (radial-tangential) or 4 (equidistant); further ones must be zero.
[[nodiscard]] Status set_distortion(CameraModel& camera, const std::vector<double>& coefficients,
                                    const YamlDocument& file, std::string_view key);

}  // namespace kinetrace::hal

// KITTI's calibration text: "KEY: numbers" lines.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/calibration_reader.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::hal {

class KittiCalibrationFile {
 public:
  /// Errors: kNotFound, kIo, kBadCalibration (a key twice).
  [[nodiscard]] static Result<KittiCalibrationFile> load(const std::filesystem::path& path);

  [[nodiscard]] std::string source() const { return path_.string(); }
  /// Errors: kBadCalibration: missing, not `count` finite numbers.
  [[nodiscard]] Result<std::vector<double>> numbers(const std::string& key, std::size_t count) const;
  [[nodiscard]] Result<Eigen::Matrix3d> matrix3(const std::string& key) const;
  [[nodiscard]] Result<Eigen::Matrix<double, 3, 4>> projection(const std::string& key) const;

 private:
  std::filesystem::path path_;
  std::map<std::string, std::string> values_;
};

/// Rectified images of the cameras with these two projection keys, as in the odometry and tracking benchmarks.
[[nodiscard]] Result<RigCalibration> kitti_rectified(const KittiCalibrationFile& file, const std::string& left_key,
                                                     const std::string& right_key, const ImageSize& size);

/// Cameras "00".."03" of calib_cam_to_cam.txt. Images as large as S_xx are raw and get K, D, R_rect and P_rect; images
/// as large as S_rect_xx are rectified. `prefer_raw` decides where the two sizes are the same.
[[nodiscard]] Result<RigCalibration> kitti_raw_rig(const KittiCalibrationFile& file, const std::string& left,
                                                   const std::string& right, const ImageSize& size, bool prefer_raw);

}  // namespace kinetrace::hal

// Measurement noise of a run's points in the image, against ground truth.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/evaluation/truth.hpp"
#include "study/study_truth.hpp"

namespace kinetrace::app {

/// Standard deviations of one observation of a point.
struct PixelNoise {
  double position_px = 0.0;   ///< Of u_left, and of v.
  double disparity_px = 0.0;  ///< Of u_left - u_right.
};

/// Takes the observations of moving rigid objects. A point's true position on its object follows from its pixel in the
/// previous frame; true poses predict its pixel in this frame. Both pixels have an error, so that the residual has
/// twice the variance of one.
class PixelNoiseMeter {
 public:
  explicit PixelNoiseMeter(const StereoGeometry& geometry) : geometry_(geometry) {}

  /// Takes a frame, in ascending order.
  void add(const FrameResult& result, const Se3& T_world_cam, const std::vector<evaluation::LocatedObject>& objects,
           const TrueImages& images);

  /// From the median of magnitudes, times 1.4826 for a standard deviation: robust to outliers. None without
  /// observations.
  [[nodiscard]] std::optional<PixelNoise> noise() const;

 private:
  struct Seen {
    std::int64_t frame = 0;
    std::uint32_t object_id = 0;
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< In the object.
  };
  void add_observation(const PointObservation& observation, double depth_m, const Se3& T_cam_obj, Seen seen);

  StereoGeometry geometry_;
  std::map<std::uint32_t, Seen> last_;  ///< By point.
  std::vector<double> position_px_;
  std::vector<double> disparity_px_;
};

}  // namespace kinetrace::app

// Input of loop closure from the camera's path: keyframes with their points, and the information of each step.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "../body_adjustment.hpp"
#include "../measurement/background_measurement.hpp"
#include "kinetrace/recording/run_reader.hpp"

namespace kinetrace::batch {

/// A frame that shows a different part of the surroundings than the keyframe before it.
struct Keyframe {
  std::size_t row = 0;                 ///< Of Run::camera.
  double depth_m = 0.0;                ///< Median of its points.
  double travelled_m = 0.0;            ///< Length of the path so far.
  double variance_m2 = 0.0;            ///< Sum of the variances of its steps' positions.
  std::vector<SeenPoint> points = {};  ///< With a right match.
};

struct ObservedPath {
  std::vector<Keyframe> keyframes;
  /// By row: inverse covariance of the left perturbation of the step from the row before.
  std::vector<Matrix6d> step_information;
};

/// Reads the background's observations once. A keyframe begins where the camera has moved by a twentieth of the median
/// depth, or turned by five degrees. Memory: 20 KiB a keyframe. Errors: those of ObservationReader.
[[nodiscard]] Result<ObservedPath> observe_path(const recording::Run& run, const MeasuredBackground& measured,
                                                std::span<const Se3> T_world_cam, double sigma_px);

}  // namespace kinetrace::batch

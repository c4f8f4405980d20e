// The camera's path and the background's points over the whole recording.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "body_adjustment.hpp"
#include "kinetrace/recording/run_reader.hpp"
#include "measurement/background_measurement.hpp"

namespace kinetrace::batch {

struct RefinedCamera {
  std::vector<Se3> T_world_cam;      ///< One per row of Run::camera.
  std::vector<RefinedPoint> points;  ///< World frame; `last_frame` is a row of Run::camera.
  double sigma_px = 0.0;             ///< Of the observations, from the residuals.
};

/// Adjusts overlapping stretches of frames one after the other, with the poses of the previous one fixed in the
/// overlap: time grows with the recording's length, memory does not. Where few points are seen, the run's own steps
/// constrain the path. After `options.keep_going` ends, the remaining path follows the run's steps. `progress` gets the
/// number of rows done. Errors: those of the reader and of the solver.
[[nodiscard]] Result<RefinedCamera> refine_camera(const recording::Run& run, const MeasuredBackground& measured,
                                                  const AdjustmentOptions& options,
                                                  const std::function<void(std::size_t)>& progress);

}  // namespace kinetrace::batch

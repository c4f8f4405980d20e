// Rescales a run whose true stereo baseline differs from its calibration.
#pragma once

#include "kinetrace/recording/run_reader.hpp"

namespace kinetrace::batch {

/// Multiplies all lengths of a run by `scale`: the baseline, paths, boxes, velocities and their deviations. Pixels and
/// angles stay.
void scale_run(double scale, recording::Run& run);

}  // namespace kinetrace::batch

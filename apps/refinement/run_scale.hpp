// A run whose stereo baseline was not what its calibration says.
#pragma once

#include "kinetrace/recording/run_reader.hpp"

namespace kinetrace::batch {

/// Makes all metres of a run `scale` times as long: the baseline, paths, boxes, velocities and their deviations. Pixels
/// and angles stay.
void scale_run(double scale, recording::Run& run);

}  // namespace kinetrace::batch

// Whether a recording is that of a run.
#pragma once

#include <string>

#include "figure/figure_images.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/recording/run_reader.hpp"

namespace kinetrace::figure {

/// The run's points must show the same surface in two of the recording's images each; without evidence of that (no
/// observations, frames without images), times of frames must agree. `name`: of the recording, for the error. Reads ten
/// image pairs. Recordings in which the camera stands still are not distinguished. Errors: kBadFormat (another
/// recording, or images of another size).
[[nodiscard]] Status check_same_recording(const recording::Run& run, const std::string& name, RecordedImages& images);

}  // namespace kinetrace::figure

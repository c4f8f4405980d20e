// A recording for a study: images, masks, ground truth.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cli/failure.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "study/study_truth.hpp"

namespace kinetrace::app {

struct StudyRecording {
  std::string name;
  hal::Dataset dataset;
  std::string segmentation;  ///< Value of --segmentation.
  StudyTruth truth;
};

/// Checks that the folders exist, and that none is named twice. Errors: kNotFound, kIo, kInvalidArgument.
[[nodiscard]] Status check_study_recordings(const std::vector<std::filesystem::path>& recordings);
/// A folder made by kinetrace-simulate. `masks`: "detections", or "instances" for exact masks.
[[nodiscard]] Outcome<StudyRecording> open_study_recording(const std::filesystem::path& path, const std::string& masks);
/// Creates the folder of a study's results, if missing. Errors: kOccupied (it lies in a recording), kIo.
[[nodiscard]] Status make_study_folder(const std::filesystem::path& directory,
                                       const std::vector<std::filesystem::path>& recordings);

}  // namespace kinetrace::app

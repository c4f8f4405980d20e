// A recording that is studied: images, masks, truth.
#pragma once

#include <filesystem>
#include <string>

#include "cli/failure.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "study/study_truth.hpp"

namespace kinetrace::app {

struct StudyRecording {
  std::string name;
  hal::Dataset dataset;
  std::string segmentation;  ///< As --segmentation has it.
  StudyTruth truth;
};

/// A folder made by kinetrace-simulate. `masks` are "detections" or "instances": the exact ones.
[[nodiscard]] Outcome<StudyRecording> open_study_recording(const std::filesystem::path& path, const std::string& masks);
/// Makes the folder of a study's results, if there is none.
[[nodiscard]] Status make_study_folder(const std::filesystem::path& directory);

}  // namespace kinetrace::app

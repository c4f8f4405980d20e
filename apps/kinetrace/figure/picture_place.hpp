// Checks of paths for pictures.
#pragma once

#include <filesystem>

#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/frame_list.hpp"

namespace kinetrace::figure {

/// A picture may replace only an earlier picture (a PNG of 8-bit colours, as `figure` writes) or an empty file. Errors:
/// kOccupied.
[[nodiscard]] Status check_replaceable(const std::filesystem::path& file);

/// Folders of the recording are refused: pictures of frames have the names of its images. Errors: kOccupied.
[[nodiscard]] Status check_apart(const std::filesystem::path& directory, const hal::FrameList& recording);

}  // namespace kinetrace::figure

// Where a picture may be written.
#pragma once

#include <filesystem>

#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/frame_list.hpp"

namespace kinetrace::figure {

/// A picture may take the place of an earlier picture (a PNG of 8-bit colours, as all of figure's are) or of an
/// empty file, and of nothing else. Errors: kInvalidArgument.
[[nodiscard]] Status check_replaceable(const std::filesystem::path& file);

/// The recording's own folders are never written into: pictures of frames have the names of its images.
/// Errors: kInvalidArgument.
[[nodiscard]] Status check_apart(const std::filesystem::path& directory, const hal::FrameList& recording);

}  // namespace kinetrace::figure

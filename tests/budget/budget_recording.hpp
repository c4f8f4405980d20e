// Recordings for the budget: a real street if available, otherwise a rendered one.
#pragma once

#include <filesystem>
#include <optional>

#include "rendered_clip.hpp"

namespace kinetrace::test {

using BudgetRecording = RenderedClip;

/// The raw street clip with its masks, below KINETRACE_DATA (default ../shared/data beside the source tree).
[[nodiscard]] std::optional<BudgetRecording> street_clip();

/// A rendered street in KITTI odometry layout, with masks of one moving box, written below `folder`.
[[nodiscard]] BudgetRecording rendered_clip(const std::filesystem::path& folder);

/// Whether KINETRACE_LONG_TESTS is in the environment.
[[nodiscard]] bool is_long();

/// Number of passes of a recording, more with KINETRACE_LONG_TESTS in the environment: a leak of a few bytes a frame
/// takes long to show.
[[nodiscard]] int passes();

}  // namespace kinetrace::test

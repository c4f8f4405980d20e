// What the budget is measured on: a real street where there is one, a rendered one otherwise.
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

/// KINETRACE_LONG_TESTS is in the environment.
[[nodiscard]] bool is_long();

/// How often a recording is played. More often with KINETRACE_LONG_TESTS in the environment: a leak of a few bytes a
/// frame takes long to show.
[[nodiscard]] int passes();

}  // namespace kinetrace::test

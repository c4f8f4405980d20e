// Writes run.json.
#pragma once

#include <span>
#include <string>

#include "kinetrace/core/result.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/recording/run_summary.hpp"
#include "run_folder.hpp"

namespace kinetrace::recording {

/// The text of run.json. Bytes that are not UTF-8 become replacement characters, numbers that are not finite null.
/// Errors: kInvalidArgument (config_json is no JSON object).
[[nodiscard]] Result<std::string> run_json_text(const RunSummary& summary, const StereoGeometry& geometry,
                                                std::span<const FileEntry> files, std::uint64_t stray_points = 0);

}  // namespace kinetrace::recording

// run.json: what a run has to say about itself.
#pragma once

#include <span>
#include <string>

#include "kinetrace/core/result.hpp"
#include "kinetrace/recording/run_summary.hpp"
#include "run_folder.hpp"

namespace kinetrace::recording {

/// The text of run.json. Bytes that are not UTF-8 become replacement characters, numbers that are not finite null.
/// Errors: kInvalidArgument (config_json is no JSON object).
[[nodiscard]] Result<std::string> run_json_text(const RunSummary& summary, std::span<const FileEntry> files);

}  // namespace kinetrace::recording

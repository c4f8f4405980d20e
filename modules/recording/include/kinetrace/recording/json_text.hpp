// JSON files before they are parsed. For host-side tools; allocates.
#pragma once

#include <filesystem>
#include <string>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::recording {

/// The text of a JSON file that a parser and a writer that call themselves for each level can take: nested 64 deep at
/// most. Whether it is JSON is for the parser to say. Errors: those of read_file, kBadFormat (nested deeper).
[[nodiscard]] KINETRACE_API Result<std::string> read_json_text(const std::filesystem::path& path);

}  // namespace kinetrace::recording

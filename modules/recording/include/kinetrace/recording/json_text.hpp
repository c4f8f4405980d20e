// Bounds the nesting of JSON files before parsing. For host-side tools; allocates.
#pragma once

#include <filesystem>
#include <string>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::recording {

/// Reads the text of a JSON file nested at most 64 deep, for recursive parsers and writers. Does not check the syntax.
/// Errors: those of InputFile::read_whole with at most 64 MiB, kBadFormat (nested deeper).
[[nodiscard]] KINETRACE_API Result<std::string> read_json_text(const std::filesystem::path& path);

}  // namespace kinetrace::recording

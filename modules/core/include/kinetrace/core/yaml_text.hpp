// Detection of further documents in a YAML text.
#pragma once

#include <optional>
#include <string_view>

#include "kinetrace/core/export.hpp"

namespace kinetrace {

/// The line, from 1, in which a second document begins; none in a text of one. yaml-cpp's Load silently takes the first
/// document alone, and LoadAll may never end on malformed text.
[[nodiscard]] KINETRACE_API std::optional<int> second_document_line(std::string_view yaml);

/// Message about it, after the file and the line.
inline constexpr std::string_view kSecondDocument =
    "a second document begins here, and only the first would be read; remove the separator or what follows it";

}  // namespace kinetrace

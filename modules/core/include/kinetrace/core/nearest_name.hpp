// Suggests the intended name for a misspelt one. For messages to people; allocates.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "kinetrace/core/export.hpp"

namespace kinetrace {

/// The one of `names` that is fewest edits (letters added, left out, replaced, or two exchanged) away from `word`; none
/// beyond a quarter of its letters, or two in short words.
[[nodiscard]] KINETRACE_API std::optional<std::string_view> nearest_name(std::string_view word,
                                                                         std::span<const std::string_view> names);

/// "; did you mean NAME?" to end a message with; empty if no name is near.
[[nodiscard]] KINETRACE_API std::string did_you_mean(std::string_view word, std::span<const std::string_view> names);

}  // namespace kinetrace

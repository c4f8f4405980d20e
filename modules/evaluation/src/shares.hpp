// Shares in percent, for reports.
#pragma once

#include <cstddef>
#include <optional>

namespace kinetrace::evaluation {

/// None for an empty whole.
[[nodiscard]] inline std::optional<double> percent(std::size_t part, std::size_t whole) noexcept {
  return whole > 0 ? std::optional(100.0 * static_cast<double>(part) / static_cast<double>(whole)) : std::nullopt;
}

}  // namespace kinetrace::evaluation

// What is printed inside a marker.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "target.hpp"

namespace kinetrace::calibration {

/// OpenCV's number of a dictionary of ArUco markers; none for another name.
[[nodiscard]] std::optional<int> dictionary_number(std::string_view dictionary);

/// Rows of cells from the top, border included, black where true. Empty for a marker that the dictionary does not have.
using MarkerBits = std::vector<std::vector<bool>>;
[[nodiscard]] MarkerBits marker_bits(const Target& target, int id);

}  // namespace kinetrace::calibration

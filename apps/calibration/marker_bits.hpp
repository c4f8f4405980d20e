// Bit patterns of markers.
#pragma once

#include <string_view>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "target.hpp"

namespace kinetrace::calibration {

/// OpenCV's number of a dictionary of ArUco markers. Errors: kInvalidArgument (another name; lists those that there
/// are).
[[nodiscard]] Result<int> dictionary_number(std::string_view dictionary);

/// Rows of cells from the top, border included, true is black. Empty for a marker that is not in the dictionary.
using MarkerBits = std::vector<std::vector<bool>>;
[[nodiscard]] MarkerBits marker_bits(const Target& target, int id);

}  // namespace kinetrace::calibration

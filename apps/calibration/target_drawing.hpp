// A target to print.
#pragma once

#include <string>

#include "kinetrace/core/result.hpp"
#include "target.hpp"

namespace kinetrace::calibration {

/// A black rectangle of a target, in its own frame.
struct BlackRectangle {
  Eigen::Vector2d from_m;
  Eigen::Vector2d to_m;
};

/// All black areas. Errors: kInvalidArgument (the dictionary has fewer markers than the target).
[[nodiscard]] Result<std::vector<BlackRectangle>> black_rectangles(const Target& target);

/// As an SVG in its true size, with a white margin. Errors: as black_rectangles.
[[nodiscard]] Result<std::string> target_svg(const Target& target);

}  // namespace kinetrace::calibration

// A target to print.
#pragma once

#include <filesystem>
#include <string>

#include "kinetrace/core/result.hpp"
#include "target.hpp"

namespace kinetrace::calibration {

/// A black rectangle of a target, in its own frame.
struct BlackRectangle {
  Eigen::Vector2d from_m;
  Eigen::Vector2d to_m;
};

/// All black areas. Errors: kInvalidArgument (an unknown dictionary, or one that has fewer markers than the target).
[[nodiscard]] Result<std::vector<BlackRectangle>> black_rectangles(const Target& target);

/// As an SVG in its true size, with a white margin. Errors: as black_rectangles.
[[nodiscard]] Result<std::string> target_svg(const Target& target);
/// Whether a file is such an SVG.
[[nodiscard]] bool is_target_svg(const std::filesystem::path& path);

}  // namespace kinetrace::calibration

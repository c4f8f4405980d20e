// Convex hull of an image region, by its first or last pixel of each row.
#pragma once

#include <cstddef>
#include <limits>
#include <span>

namespace kinetrace::segmentation {

/// Row without a pixel.
inline constexpr float kNoColumn = std::numeric_limits<float>::infinity();

/// first_column[row] <- its greatest convex lower bound, from the first row that is not kNoColumn to the last one.
/// For the right side of a region, give negated columns. In place; takes no memory.
void make_convex(std::span<float> first_column) noexcept;

}  // namespace kinetrace::segmentation

#include "row_hull.hpp"

namespace kinetrace::segmentation {

// Gift wrapping: from a corner, the next one is that in the direction of the least slope.
void make_convex(std::span<float> first_column) noexcept {
  std::size_t corner = 0;
  while (corner < first_column.size() && first_column[corner] == kNoColumn) {
    ++corner;
  }
  while (corner < first_column.size()) {
    std::size_t next = first_column.size();
    float least = 0.F;
    for (std::size_t row = corner + 1; row < first_column.size(); ++row) {
      const float slope = (first_column[row] - first_column[corner]) / static_cast<float>(row - corner);
      if (first_column[row] != kNoColumn && (next == first_column.size() || slope <= least)) {
        next = row;
        least = slope;
      }
    }
    for (std::size_t row = corner + 1; next < first_column.size() && row < next; ++row) {
      first_column[row] = first_column[corner] + least * static_cast<float>(row - corner);
    }
    corner = next;
  }
}

}  // namespace kinetrace::segmentation

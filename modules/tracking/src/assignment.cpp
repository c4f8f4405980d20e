#include "kinetrace/tracking/assignment.hpp"

#include "kinetrace/core/assignment.hpp"

namespace kinetrace::tracking {

Assignment maximum_weight_assignment(const AffinityMatrix& affinity) noexcept {
  constexpr std::size_t kSize = static_cast<std::size_t>(kMaxObjects) + 1;
  std::array<double, kSize> row_potential;
  std::array<double, kSize> column_potential;
  std::array<double, kSize> slack;
  std::array<std::size_t, kSize> row_of_column;
  std::array<std::size_t, kSize> previous_column;
  std::array<bool, kSize> in_tree;
  Assignment column_of_row;
  assign(
      static_cast<std::size_t>(affinity.rows()), static_cast<std::size_t>(affinity.columns()),
      [&](std::size_t u, std::size_t v) { return affinity(static_cast<int>(u), static_cast<int>(v)); },
      {row_potential, column_potential, slack, row_of_column, previous_column, in_tree}, column_of_row);
  return column_of_row;
}

}  // namespace kinetrace::tracking

#include "kinetrace/tracking/assignment.hpp"

#include <algorithm>
#include <limits>

namespace kinetrace::tracking {
namespace {

constexpr std::size_t kSize = static_cast<std::size_t>(kMaxObjects) + 1;  // index 0 is the algorithm's root

}  // namespace

// Minimises cost = -weight row by row: each new row grows an alternating tree along the cheapest reduced costs until a
// free column is found. The shorter side plays the rows, so that every row finds a column.
Assignment maximum_weight_assignment(const AffinityMatrix& affinity) noexcept {
  const bool transposed = affinity.rows() > affinity.columns();
  const auto n = static_cast<std::size_t>(transposed ? affinity.columns() : affinity.rows());
  const auto m = static_cast<std::size_t>(transposed ? affinity.rows() : affinity.columns());
  const auto cost = [&](std::size_t row, std::size_t column) {
    const int u = static_cast<int>(transposed ? column : row) - 1;
    const int v = static_cast<int>(transposed ? row : column) - 1;
    return -std::max(0.0, affinity(u, v));
  };

  std::array<double, kSize> row_potential{};
  std::array<double, kSize> column_potential{};
  std::array<std::size_t, kSize> row_of_column{};  // 0 = free
  std::array<std::size_t, kSize> previous_column{};
  for (std::size_t row = 1; row <= n; ++row) {
    std::array<double, kSize> slack;
    slack.fill(std::numeric_limits<double>::infinity());
    std::array<bool, kSize> in_tree{};
    row_of_column[0] = row;
    std::size_t column = 0;
    do {
      in_tree[column] = true;
      const std::size_t tree_row = row_of_column[column];
      double delta = std::numeric_limits<double>::infinity();
      std::size_t next = 0;
      for (std::size_t j = 1; j <= m; ++j) {
        if (in_tree[j]) {
          continue;
        }
        const double reduced = cost(tree_row, j) - row_potential[tree_row] - column_potential[j];
        if (reduced < slack[j]) {
          slack[j] = reduced;
          previous_column[j] = column;
        }
        if (slack[j] < delta) {
          delta = slack[j];
          next = j;
        }
      }
      for (std::size_t j = 0; j <= m; ++j) {
        if (in_tree[j]) {
          row_potential[row_of_column[j]] += delta;
          column_potential[j] -= delta;
        } else {
          slack[j] -= delta;
        }
      }
      column = next;
    } while (row_of_column[column] != 0);
    while (column != 0) {
      const std::size_t before = previous_column[column];
      row_of_column[column] = row_of_column[before];
      column = before;
    }
  }

  Assignment column_of_row;
  column_of_row.fill(-1);
  for (std::size_t j = 1; j <= m; ++j) {
    const std::size_t i = row_of_column[j];
    if (i != 0 && cost(i, j) < 0.0) {
      const std::size_t u = (transposed ? j : i) - 1;
      const std::size_t v = (transposed ? i : j) - 1;
      column_of_row[u] = static_cast<int>(v);
    }
  }
  return column_of_row;
}

}  // namespace kinetrace::tracking

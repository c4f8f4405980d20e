// Maximum-weight matching of a bipartite graph: Kuhn-Munkres.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <limits>
#include <span>

namespace kinetrace {

/// Working memory of `assign`, each span one longer than the larger side of the graph.
struct AssignmentMemory {
  std::span<double> row_potential;
  std::span<double> column_potential;
  std::span<double> slack;
  std::span<std::size_t> row_of_column;
  std::span<std::size_t> previous_column;
  std::span<bool> in_tree;
};

namespace detail {

/// Grows an alternating tree from the row at column 0 along the cheapest reduced costs until it reaches a free column,
/// and returns that column. `columns` excludes the root at 0.
template <typename Cost>
std::size_t grow_tree(std::size_t columns, const Cost& cost, const AssignmentMemory& memory) {
  const auto& [row_potential, column_potential, slack, row_of_column, previous_column, in_tree] = memory;
  std::fill(slack.begin(), slack.end(), std::numeric_limits<double>::infinity());
  std::fill(in_tree.begin(), in_tree.end(), false);
  std::size_t column = 0;
  do {
    in_tree[column] = true;
    const std::size_t tree_row = row_of_column[column];
    double delta = std::numeric_limits<double>::infinity();
    std::size_t next = 0;
    for (std::size_t j = 1; j <= columns; ++j) {
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
    for (std::size_t j = 0; j <= columns; ++j) {
      if (in_tree[j]) {
        row_potential[row_of_column[j]] += delta;
        column_potential[j] -= delta;
      } else {
        slack[j] -= delta;
      }
    }
    column = next;
  } while (row_of_column[column] != 0);
  return column;
}

/// Matches along the path from a free column back to the root.
inline void augment(std::size_t column, const AssignmentMemory& memory) {
  while (column != 0) {
    const std::size_t before = memory.previous_column[column];
    memory.row_of_column[column] = memory.row_of_column[before];
    column = before;
  }
}

}  // namespace detail

/// Writes the column of each row, or -1, so that the sum of weight(row, column) is greatest. Pairs whose weight is not
/// above zero are left unmatched. Ties are broken deterministically. O(n^3), no memory of its own. (Kuhn 1955, Munkres
/// 1957; here by shortest augmenting paths with potentials, Jonker and Volgenant 1987.)
template <typename Weight>
void assign(std::size_t rows, std::size_t columns, const Weight& weight, const AssignmentMemory& memory,
            std::span<int> column_of_row) {
  // Minimises cost = -weight row by row. The shorter side provides the rows, so that every row finds a column. Index 0
  // is the root.
  const bool transposed = rows > columns;
  const std::size_t n = transposed ? columns : rows;
  const std::size_t m = transposed ? rows : columns;
  assert(memory.slack.size() > m && column_of_row.size() >= rows);
  const auto cost = [&](std::size_t i, std::size_t j) {
    return -std::max(0.0, transposed ? weight(j - 1, i - 1) : weight(i - 1, j - 1));
  };

  std::fill(memory.row_potential.begin(), memory.row_potential.end(), 0.0);
  std::fill(memory.column_potential.begin(), memory.column_potential.end(), 0.0);
  std::fill(memory.row_of_column.begin(), memory.row_of_column.end(), 0);  // 0 = free
  std::fill(memory.previous_column.begin(), memory.previous_column.end(), 0);
  for (std::size_t row = 1; row <= n; ++row) {
    memory.row_of_column[0] = row;
    detail::augment(detail::grow_tree(m, cost, memory), memory);
  }

  std::fill(column_of_row.begin(), column_of_row.end(), -1);
  for (std::size_t j = 1; j <= m; ++j) {
    const std::size_t i = memory.row_of_column[j];
    if (i != 0 && cost(i, j) < 0.0) {
      column_of_row[(transposed ? j : i) - 1] = static_cast<int>((transposed ? i : j) - 1);
    }
  }
}

}  // namespace kinetrace

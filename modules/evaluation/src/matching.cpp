#include "kinetrace/evaluation/matching.hpp"

#include <algorithm>
#include <memory>

#include "kinetrace/core/assignment.hpp"

namespace kinetrace::evaluation {

std::vector<int> best_matching(const Eigen::MatrixXd& weights) {
  const auto rows = static_cast<std::size_t>(weights.rows());
  const auto columns = static_cast<std::size_t>(weights.cols());
  const std::size_t size = std::max(rows, columns) + 1;
  std::vector<double> numbers(3 * size);
  std::vector<std::size_t> indices(2 * size);
  const std::unique_ptr<bool[]> in_tree = std::make_unique<bool[]>(size);  // vector<bool> has no contiguous bools.
  const std::span<double> all_numbers(numbers);
  const std::span<std::size_t> all_indices(indices);
  std::vector<int> column_of_row(rows, -1);
  assign(
      rows, columns,
      [&](std::size_t row, std::size_t column) {
        return weights(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column));
      },
      {all_numbers.subspan(0, size),
       all_numbers.subspan(size, size),
       all_numbers.subspan(2 * size, size),
       all_indices.subspan(0, size),
       all_indices.subspan(size, size),
       {in_tree.get(), size}},
      column_of_row);
  return column_of_row;
}

}  // namespace kinetrace::evaluation

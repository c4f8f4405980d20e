// Matrices from numbers in a file.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace kinetrace::hal {

/// `values` row by row, exactly as many as the matrix has.
template <int Rows, int Columns>
[[nodiscard]] Eigen::Matrix<double, Rows, Columns> row_major(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::Matrix<double, Rows, Columns, Eigen::RowMajor>>(values.data());
}

}  // namespace kinetrace::hal

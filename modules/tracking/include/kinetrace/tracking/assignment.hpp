// Maximum-weight matching of a small bipartite graph: Kuhn-Munkres.
#pragma once

#include <array>
#include <cstddef>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace::tracking {

/// Weights of the pairs (row u, column v), at most kMaxObjects each way. Zero = no edge; negative weights count as
/// zero.
class AffinityMatrix {
 public:
  void resize(int rows, int columns) noexcept {
    rows_ = rows;
    columns_ = columns;
    for (int u = 0; u < rows; ++u) {
      weights_[static_cast<std::size_t>(u)].fill(0.0);
    }
  }
  [[nodiscard]] int rows() const noexcept { return rows_; }
  [[nodiscard]] int columns() const noexcept { return columns_; }
  [[nodiscard]] double& operator()(int u, int v) noexcept {
    return weights_[static_cast<std::size_t>(u)][static_cast<std::size_t>(v)];
  }
  [[nodiscard]] double operator()(int u, int v) const noexcept {
    return weights_[static_cast<std::size_t>(u)][static_cast<std::size_t>(v)];
  }

 private:
  int rows_ = 0;
  int columns_ = 0;
  std::array<std::array<double, kMaxObjects>, kMaxObjects> weights_{};
};

/// Column of each row, or -1.
using Assignment = std::array<int, kMaxObjects>;

/// The matching of greatest total weight (Kuhn-Munkres, see core/assignment.hpp; O(n^3)). Pairs of weight zero are left
/// unmatched. Ties are broken deterministically. Fixed memory, on the stack.
[[nodiscard]] Assignment maximum_weight_assignment(const AffinityMatrix& affinity) noexcept;

}  // namespace kinetrace::tracking

// Who is who in one frame: truth against estimate.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace kinetrace::evaluation {

/// Column of each row, or -1: the matching with the greatest sum of weights, of pairs whose weight is above zero
/// (Kuhn-Munkres).
[[nodiscard]] std::vector<int> best_matching(const Eigen::MatrixXd& weights);

}  // namespace kinetrace::evaluation

// Optimal matching of truth and estimate in one frame.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace kinetrace::evaluation {

/// Column of each row, or -1: the matching with the greatest sum of weights, using only weights above zero
/// (Kuhn-Munkres).
[[nodiscard]] std::vector<int> best_matching(const Eigen::MatrixXd& weights);

}  // namespace kinetrace::evaluation

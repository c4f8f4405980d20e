#include "kinetrace/tracking/assignment.hpp"

#include <algorithm>
#include <memory>
#include <random>

#include <gtest/gtest.h>

namespace kinetrace::tracking {
namespace {

double total(const AffinityMatrix& a, const Assignment& match) {
  double sum = 0.0;
  for (int u = 0; u < a.rows(); ++u) {
    const int v = match[static_cast<std::size_t>(u)];
    sum += v >= 0 ? a(u, v) : 0.0;
  }
  return sum;
}

/// Greatest total over all ways to match rows u, u+1, ... with columns not in `used`.
double brute_force(const AffinityMatrix& a, int u, unsigned used) {
  if (u == a.rows()) {
    return 0.0;
  }
  double best = brute_force(a, u + 1, used);
  for (int v = 0; v < a.columns(); ++v) {
    if ((used >> static_cast<unsigned>(v) & 1U) == 0) {
      best = std::max(best, std::max(0.0, a(u, v)) + brute_force(a, u + 1, used | 1U << static_cast<unsigned>(v)));
    }
  }
  return best;
}

void expect_valid(const AffinityMatrix& a, const Assignment& match) {
  std::array<int, kMaxObjects> uses{};
  for (std::size_t u = 0; u < match.size(); ++u) {
    if (match[u] < 0) {
      continue;
    }
    ASSERT_LT(static_cast<int>(u), a.rows());
    ASSERT_LT(match[u], a.columns());
    EXPECT_GT(a(static_cast<int>(u), match[u]), 0.0);
    EXPECT_EQ(++uses[static_cast<std::size_t>(match[u])], 1);
  }
}

class MaximumWeightAssignment : public ::testing::Test {
 protected:
  AffinityMatrix& matrix(int rows, int columns) {
    matrix_->resize(rows, columns);
    return *matrix_;
  }

 private:
  std::unique_ptr<AffinityMatrix> matrix_ = std::make_unique<AffinityMatrix>();
};

TEST_F(MaximumWeightAssignment, FindsTheBruteForceOptimumOfRandomMatrices) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> size(0, 6);
  std::uniform_real_distribution<double> weight(-0.3, 1.0);
  for (int trial = 0; trial < 400; ++trial) {
    AffinityMatrix& a = matrix(size(random), size(random) + trial % 2);
    for (int u = 0; u < a.rows(); ++u) {
      for (int v = 0; v < a.columns(); ++v) {
        a(u, v) = weight(random);
      }
    }
    const Assignment match = maximum_weight_assignment(a);
    expect_valid(a, match);
    EXPECT_NEAR(total(a, match), brute_force(a, 0, 0), 1e-12) << a.rows() << 'x' << a.columns();
  }
}

TEST_F(MaximumWeightAssignment, FindsTheBruteForceOptimumWithTies) {
  std::mt19937 random(4);
  std::uniform_int_distribution<int> weight(0, 2);
  for (int trial = 0; trial < 200; ++trial) {
    AffinityMatrix& a = matrix(2 + trial % 5, 7 - trial % 6);
    for (int u = 0; u < a.rows(); ++u) {
      for (int v = 0; v < a.columns(); ++v) {
        a(u, v) = 0.5 * weight(random);
      }
    }
    const Assignment match = maximum_weight_assignment(a);
    expect_valid(a, match);
    EXPECT_EQ(total(a, match), brute_force(a, 0, 0));
    EXPECT_EQ(match, maximum_weight_assignment(a));
  }
}

TEST_F(MaximumWeightAssignment, PrefersTheGreatestSumOverTheGreatestPair) {
  AffinityMatrix& a = matrix(2, 2);
  a(0, 0) = 0.9;
  a(0, 1) = 0.8;
  a(1, 0) = 0.7;
  const Assignment match = maximum_weight_assignment(a);
  EXPECT_EQ(match[0], 1);
  EXPECT_EQ(match[1], 0);
}

TEST_F(MaximumWeightAssignment, MatchesNothingWithoutWeight) {
  const Assignment match = maximum_weight_assignment(matrix(5, 3));
  EXPECT_TRUE(std::all_of(match.begin(), match.end(), [](int v) { return v == -1; }));
}

TEST_F(MaximumWeightAssignment, TakesNoRowsOrNoColumns) {
  EXPECT_EQ(maximum_weight_assignment(matrix(0, 0))[0], -1);
  EXPECT_EQ(maximum_weight_assignment(matrix(0, 4))[0], -1);
  EXPECT_EQ(maximum_weight_assignment(matrix(4, 0))[0], -1);
}

TEST_F(MaximumWeightAssignment, SolvesItsLargestProblem) {
  AffinityMatrix& a = matrix(kMaxObjects, kMaxObjects);
  for (int u = 0; u < kMaxObjects; ++u) {
    for (int v = 0; v < kMaxObjects; ++v) {
      a(u, v) = v == (u * 37 + 5) % kMaxObjects ? 1.0 : 0.9;  // 37 is odd, so this is a permutation of 64
    }
  }
  const Assignment match = maximum_weight_assignment(a);
  EXPECT_DOUBLE_EQ(total(a, match), kMaxObjects);
}

}  // namespace
}  // namespace kinetrace::tracking

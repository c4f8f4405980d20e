#include "kinetrace/core/workers.hpp"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace {
namespace {

/// Calls the job for each of several workers in turn.
class InTurn final : public Workers {
 public:
  explicit InTurn(std::size_t count) : count_(count) {}
  void run(Job job) noexcept override {
    ++rounds;
    for (std::size_t i = 0; i < count_; ++i) {
      job(i);
    }
  }
  int rounds = 0;

 private:
  std::size_t count_;
};

std::vector<int> times_worked_on(Workers* workers, std::size_t count, std::size_t piece) {
  std::vector<int> times(count, 0);
  in_pieces(workers, count, piece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      ++times[i];
    }
  });
  return times;
}

TEST(Workers, EverythingIsWorkedOnOnce) {
  for (const std::size_t count : {0U, 1U, 7U, 8U, 9U, 64U, 65U}) {
    InTurn three(3);
    EXPECT_EQ(times_worked_on(nullptr, count, 8), std::vector<int>(count, 1)) << count;
    EXPECT_EQ(times_worked_on(&three, count, 8), std::vector<int>(count, 1)) << count;
  }
}

TEST(Workers, PiecesAreAtMostAsLargeAsAskedFor) {
  InTurn two(2);
  std::size_t largest = 0;
  in_pieces(&two, 100, 16, [&](std::size_t begin, std::size_t end) { largest = std::max(largest, end - begin); });
  EXPECT_EQ(largest, 16U);
}

TEST(Workers, NoHelperIsCalledForASinglePiece) {
  InTurn two(2);
  EXPECT_EQ(times_worked_on(&two, 8, 8), std::vector<int>(8, 1));
  EXPECT_EQ(two.rounds, 0);
}

}  // namespace
}  // namespace kinetrace

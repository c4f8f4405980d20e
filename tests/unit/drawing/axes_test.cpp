#include "drawing/axes.hpp"

#include <cmath>
#include <limits>

#include "pixels.hpp"

namespace kinetrace::drawing {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> labels(const std::vector<Tick>& ticks) {
  std::vector<std::string> texts;
  for (const Tick& tick : ticks) {
    if (!tick.label.empty()) {
      texts.push_back(tick.label);
    }
  }
  return texts;
}

TEST(LinearTicks, AreRoundAndIncludeTheEnds) {
  EXPECT_THAT(labels(linear_ticks({0.0, 10.0}, 5)), ElementsAre("0", "2", "4", "6", "8", "10"));
  EXPECT_THAT(labels(linear_ticks({-1.0, 1.0}, 4)), ElementsAre("-1.0", "-0.5", "0.0", "0.5", "1.0"));
  EXPECT_THAT(labels(linear_ticks({0.012, 0.038}, 3)), ElementsAre("0.02", "0.03"));
  EXPECT_THAT(labels(linear_ticks({995.0, 1015.0}, 2)), ElementsAre("1000", "1010"));
}

TEST(LinearTicks, AreNeverMoreThanAskedFor) {
  for (double size = 0.001; size < 1e5; size *= 1.7) {
    for (const int most : {2, 3, 5, 9}) {
      const std::size_t count = linear_ticks({0.0, size}, most).size();
      EXPECT_LE(count, static_cast<std::size_t>(most) + 1) << size;
      EXPECT_GE(count, 1U) << size;
    }
  }
}

TEST(LinearTicks, AreNoneForAnEmptyOrEndlessRange) {
  EXPECT_TRUE(linear_ticks({3.0, 3.0}, 5).empty());
  EXPECT_TRUE(linear_ticks({0.0, std::numeric_limits<double>::infinity()}, 5).empty());
}

TEST(LogTicks, AreDecadesAndSomeBetween) {
  EXPECT_THAT(labels(log_ticks({0.01, 100.0})), ElementsAre("0.01", "0.1", "1", "10", "100"));
  EXPECT_THAT(labels(log_ticks({10.0, 100.0})), ElementsAre("10", "20", "50", "100"));
  EXPECT_THAT(labels(log_ticks({2.0, 5.0})), ElementsAre("2", "3", "4", "5"));
  EXPECT_EQ(log_ticks({1.0, 10.0}).size(), 10U);
  EXPECT_TRUE(log_ticks({0.0, 10.0}).empty());
  EXPECT_TRUE(log_ticks({-1.0, 10.0}).empty());
}

TEST(RoundNumbers, LieBelowAndAbove) {
  EXPECT_DOUBLE_EQ(round_below(7.3), 5.0);
  EXPECT_DOUBLE_EQ(round_below(5.0), 5.0);
  EXPECT_DOUBLE_EQ(round_below(0.19), 0.1);
  EXPECT_DOUBLE_EQ(round_below(1000.0), 1000.0);
  EXPECT_DOUBLE_EQ(round_above(7.3), 10.0);
  EXPECT_DOUBLE_EQ(round_above(5.0), 5.0);
  EXPECT_DOUBLE_EQ(round_above(0.11), 0.2);
  EXPECT_DOUBLE_EQ(round_above(2.1e4), 5e4);
}

TEST(TickLabel, HasTheDigitsOfTheStep) {
  EXPECT_EQ(tick_label(0.30000000000000004, 0.1), "0.3");
  EXPECT_EQ(tick_label(-1e-18, 0.5), "0.0");
  EXPECT_EQ(tick_label(20.0, 5.0), "20");
  EXPECT_EQ(tick_label(2e7, 1e7), "2e+07");
}

TEST(QuantileRange, LeavesWildValuesOut) {
  std::vector<double> values;
  for (int i = 0; i <= 100; ++i) {
    values.push_back(i);
  }
  values.push_back(std::numeric_limits<double>::quiet_NaN());
  values.push_back(std::numeric_limits<double>::infinity());
  values[50] = 1e9;
  const auto range = quantile_range(values, 0.05);
  ASSERT_TRUE(range);
  EXPECT_NEAR(range->low, 5.0, 1.0);
  EXPECT_NEAR(range->high, 96.0, 1.0);
  std::vector<double> none{std::numeric_limits<double>::quiet_NaN()};
  EXPECT_FALSE(quantile_range(none, 0.05));
  std::vector<double> one{4.0};
  EXPECT_DOUBLE_EQ(quantile_range(one, 0.05)->low, 4.0);
}

TEST(Range, GrowsAboutItsMiddle) {
  const Range range = Range{2.0, 4.0}.at_least(6.0);
  EXPECT_DOUBLE_EQ(range.low, 0.0);
  EXPECT_DOUBLE_EQ(range.high, 6.0);
  EXPECT_DOUBLE_EQ((Range{0.0, 10.0}.at_least(6.0).size()), 10.0);
  EXPECT_DOUBLE_EQ((Range{0.0, 10.0}.widened(0.1).low), -1.0);
}

TEST(Axes, PutValuesWhereTheyBelong) {
  const Axes axes({100, 50, 200, 100}, {.label = "x", .range = {0.0, 10.0}},
                  {.label = "y", .range = {1.0, 100.0}, .logarithmic = true});
  EXPECT_TRUE(axes.to_canvas(0.0, 1.0).isApprox(Point(100.0, 150.0)));
  EXPECT_TRUE(axes.to_canvas(10.0, 100.0).isApprox(Point(300.0, 50.0)));
  EXPECT_TRUE(axes.to_canvas(5.0, 10.0).isApprox(Point(200.0, 100.0)));
  EXPECT_FALSE(axes.to_canvas(5.0, 0.0).allFinite());
  const Axes reversed({0, 0, 10, 10}, {.label = "", .range = {0.0, 1.0}, .reversed = true},
                      {.label = "", .range = {0.0, 1.0}, .reversed = true});
  EXPECT_TRUE(reversed.to_canvas(0.0, 0.0).isApprox(Point(10.0, 0.0)));
}

TEST(Axes, DrawNothingBeyondTheirMargins) {
  Canvas canvas(400, 300, kPaper);
  const Rect whole{20, 20, 340, 240};
  const Axes axes(inside_margins(whole), {.label = "distance [m]", .range = {0.0, 10.0}},
                  {.label = "error [m]", .range = {-0.001, 0.001}});
  axes.draw(canvas);
  EXPECT_EQ(count_near(canvas, {0, 0, 18, 300}, kPaper, 0), 18 * 300);
  EXPECT_EQ(count_near(canvas, {0, 264, 400, 36}, kPaper, 0), 400 * 36);
  EXPECT_EQ(count_near(canvas, {0, 0, 400, 16}, kPaper, 0), 400 * 16);
  EXPECT_GT(count_near(canvas, {20, 20, 66, 200}, kInk, 60), 10) << "the label of y";
}

}  // namespace
}  // namespace kinetrace::drawing

#include "drawing/chips.hpp"

#include "pixels.hpp"

namespace kinetrace::drawing {
namespace {

constexpr Rect kArea{0, 0, 300, 150};
constexpr double kSize_px = 8.0;

/// A chip's ground, mixed with the paper below.
Color ground(const Color& color) {
  return mix(kPaper, color, 0.9);
}

TEST(Chips, StandAboveTheirTargets) {
  Canvas canvas(300, 150, kPaper);
  draw_chips(canvas, kArea, {{{"car 1"}, kInk, {120, 60, 60, 40}}}, kSize_px);
  EXPECT_GT(count_near(canvas, {120, 30, 60, 30}, ground(kInk)), 200);
  EXPECT_EQ(count_near(canvas, {0, 60, 300, 90}, kPaper, 0), 300 * 90);
}

TEST(Chips, GoBelowWhereThereIsNoRoomAbove) {
  Canvas canvas(300, 150, kPaper);
  draw_chips(canvas, kArea, {{{"car 1"}, kInk, {120, 0, 60, 40}}, {{"car 2"}, kRed, {120, 0, 60, 39}}}, kSize_px);
  EXPECT_GT(count_near(canvas, ground(kInk)), 200);
  EXPECT_GT(count_near(canvas, {100, 38, 100, 30}, ground(kRed)), 200) << "the taller one came first, to the top edge";
}

TEST(Chips, TakeAShorterTextWhereTheBestDoesNotFit) {
  Canvas narrow(60, 60, kPaper);
  draw_chips(narrow, {0, 0, 60, 60}, {{{"a very long name indeed", "7"}, kInk, {20, 30, 20, 20}}}, kSize_px);
  const int pixels = count_near(narrow, ground(kInk), 3);
  EXPECT_GT(pixels, 60);
  EXPECT_LT(pixels, 400);
}

TEST(Chips, OfACrowdLeaveTheirBestTextOut) {
  const auto ink_of = [](std::size_t count) {
    Canvas canvas(2000, 60, kPaper);
    std::vector<Chip> chips;
    for (std::size_t i = 0; i < count; ++i) {
      chips.push_back({{"long name", "7"}, i == 0 ? kRed : kInk, {20.0 + 110.0 * static_cast<double>(i), 30, 20, 20}});
    }
    draw_chips(canvas, {0, 0, 2000, 60}, chips, kSize_px);
    return count_near(canvas, {0, 0, 100, 60}, ground(kRed));
  };
  EXPECT_LT(ink_of(kCrowd + 1), ink_of(kCrowd) / 2);
  EXPECT_EQ(ink_of(1), ink_of(kCrowd));
}

TEST(Chips, WithoutRoomAreLeftOut) {
  Canvas canvas(20, 10, kPaper);
  draw_chips(canvas, {0, 0, 20, 10}, {{{"car 1"}, kInk, {5, 5, 5, 5}}}, kSize_px);
  EXPECT_EQ(count_near(canvas, kPaper, 0), 200);
  draw_chips(canvas, {0, 0, 20, 10}, {}, kSize_px);
  EXPECT_EQ(count_near(canvas, kPaper, 0), 200);
}

}  // namespace
}  // namespace kinetrace::drawing

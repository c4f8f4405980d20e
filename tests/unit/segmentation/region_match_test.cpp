#include "kinetrace/segmentation/region_match.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>

#include <gtest/gtest.h>

#include "moving_picture.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr StereoGeometry kGeometry{
    .fx_px = 200.0, .fy_px = 200.0, .cx_px = 80.0, .cy_px = 60.0, .baseline_m = 0.5, .width_px = 160, .height_px = 120};
constexpr std::uint16_t kLabel = 3;

class RegionMatchTest : public ::testing::Test {
 protected:
  /// The shift found for a board that moves from `then` to `now`.
  std::optional<Eigen::Vector2f> shift(const test::Board& then, const test::Board& now, const PredictedShift& predicted,
                                       bool plain = false) {
    fill(earlier_, then, plain);
    fill(now_, now, plain);
    const PixelBox box{static_cast<int>(then.x0), static_cast<int>(then.y0), static_cast<int>(then.x0 + then.width),
                       static_cast<int>(then.y0 + then.height)};
    for (int y = box.y0; y < box.y1; ++y) {
      std::fill(drawn_.row(y) + box.x0, drawn_.row(y) + box.x1, kLabel);
    }
    return match_.shift_px(earlier_, now_, drawn_, kLabel, box, predicted);
  }
  static void fill(ImagePyramid& pyramid, const test::Board& board, bool plain) {
    test::MovingPicture picture(kGeometry, 0.0);
    picture.draw(board, plain);
    pyramid.fill(picture.pair(0, 0).left);
  }

  Arena arena_{1 << 20};
  ImagePyramid earlier_{kGeometry.width_px, kGeometry.height_px, arena_};
  ImagePyramid now_{kGeometry.width_px, kGeometry.height_px, arena_};
  ImageView<std::uint16_t> drawn_ = take_image<std::uint16_t>(arena_, kGeometry.width_px, kGeometry.height_px);
  RegionMatch match_{arena_};
};

TEST_F(RegionMatchTest, FindsSmallAndLargeRegions) {
  EXPECT_EQ(shift({60, 40, 6, 14, 0.0}, {64, 39, 6, 14, 0.0}, {{0.F, 0.F}, 4.F}).value(), Eigen::Vector2f(4.F, -1.F));
  EXPECT_EQ(shift({20, 20, 60, 70, 0.0}, {43, 29, 60, 70, 0.0}, {{0.F, 0.F}, 20.F}).value(),
            Eigen::Vector2f(23.F, 9.F));
}

TEST_F(RegionMatchTest, WhereAllPlacesLookTheSameThePredictionCounts) {
  EXPECT_EQ(shift({20, 20, 120, 80, 0.0}, {20, 20, 120, 80, 0.0}, {{0.F, 0.F}, 5.F}, true).value(),
            Eigen::Vector2f(0.F, 0.F));
  drawn_.row(50)[70] = kLabel;
  EXPECT_EQ(match_.shift_px(earlier_, now_, drawn_, kLabel, {60, 50, 70, 60}, {{7.F, -3.F}, 5.F}).value(),
            Eigen::Vector2f(7.F, -3.F));
}

TEST_F(RegionMatchTest, AnOccluderDoesNotDragIt) {
  // The board stands still; another passes over a third of it.
  fill(earlier_, {60, 40, 18, 40, 0.0}, false);
  test::MovingPicture picture(kGeometry, 0.0);
  picture.draw({60, 40, 18, 40, 0.0});
  const MutableGrayView occluded = take_image<std::uint8_t>(arena_, kGeometry.width_px, kGeometry.height_px);
  copy_image(picture.pair(0, 0).left, occluded);
  for (int y = 40; y < 80; ++y) {
    std::fill_n(occluded.row(y) + 60, 6, std::uint8_t{200});
  }
  now_.fill(occluded);
  for (int y = 40; y < 80; ++y) {
    std::fill_n(drawn_.row(y) + 60, 18, kLabel);
  }
  EXPECT_LE(match_.shift_px(earlier_, now_, drawn_, kLabel, {60, 40, 78, 80}, {{0.F, 0.F}, 10.F}).value().norm(), 1.F);
}

TEST_F(RegionMatchTest, WhatLeavesTheImageIsWhereItWasPredicted) {
  EXPECT_EQ(shift({120, 40, 30, 40, 0.0}, {150, 44, 30, 40, 0.0}, {{28.F, 2.F}, 10.F}).value(),
            Eigen::Vector2f(30.F, 4.F));
  EXPECT_EQ(shift({120, 40, 30, 40, 0.0}, {200, 40, 30, 40, 0.0}, {{80.F, 0.F}, 10.F}).value(),
            Eigen::Vector2f(80.F, 0.F));
}

TEST_F(RegionMatchTest, HasNoAnswerWithoutImages) {
  now_.fill({});
  EXPECT_FALSE(match_.shift_px(earlier_, now_, drawn_, kLabel, {60, 40, 80, 80}, {{0.F, 0.F}, 5.F}));
}

}  // namespace
}  // namespace kinetrace::segmentation

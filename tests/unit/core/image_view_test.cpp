#include "kinetrace/core/image_view.hpp"

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace {
namespace {

TEST(ImageView, IsEmptyWithoutPixels) {
  std::uint8_t pixel = 0;
  EXPECT_TRUE(GrayView{}.empty());
  EXPECT_TRUE((GrayView{&pixel, 0, 1, 1}).empty());
  EXPECT_TRUE((GrayView{nullptr, 1, 1, 1}).empty());
  EXPECT_FALSE((GrayView{&pixel, 1, 1, 1}).empty());
}

TEST(ImageView, ContainsItsCornersAndNothingBeyond) {
  std::vector<std::uint8_t> pixels(12);
  const GrayView view{pixels.data(), 4, 3, 4};
  EXPECT_TRUE(view.contains(0, 0));
  EXPECT_TRUE(view.contains(3, 2));
  EXPECT_FALSE(view.contains(4, 0));
  EXPECT_FALSE(view.contains(0, 3));
  EXPECT_FALSE(view.contains(-1, 0));
  EXPECT_FALSE(view.contains(0, -1));
}

TEST(ImageView, CopyKeepsPixelsAndLeavesPaddingAlone) {
  std::vector<std::uint8_t> from(5 * 3, 9);
  std::vector<std::uint8_t> to(8 * 3, 77);
  const MutableGrayView source{from.data(), 4, 3, 5};
  const MutableGrayView target{to.data(), 4, 3, 8};
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 4; ++x) {
      source.at(x, y) = static_cast<std::uint8_t>(10 * y + x);
    }
  }
  copy_image<std::uint8_t>(source, target);
  EXPECT_EQ(target.at(0, 0), 0);
  EXPECT_EQ(target.at(3, 2), 23);
  EXPECT_EQ(to[4], 77);
  EXPECT_EQ(to[23], 77);
}

TEST(ImageView, TakenImagesHavePaddedRowsInsideTheArena) {
  Arena arena(1 << 16);
  const MutableGrayView image = take_image<std::uint8_t>(arena, 65, 3);
  EXPECT_EQ(image.width, 65);
  EXPECT_EQ(image.height, 3);
  EXPECT_GE(image.stride, 65);
  EXPECT_EQ(static_cast<std::size_t>(image.stride) % kRowAlignment, 0U);
  EXPECT_GE(arena.used_bytes(), static_cast<std::size_t>(image.stride) * 3U);
}

TEST(PixelBox, GrowsFromNothingToHoldItsPixels) {
  PixelBox box;
  EXPECT_TRUE(box.empty());
  box.include(5, 7);
  EXPECT_EQ(box.width(), 1);
  EXPECT_EQ(box.height(), 1);
  box.include(2, 9);
  EXPECT_EQ(box.x0, 2);
  EXPECT_EQ(box.y0, 7);
  EXPECT_EQ(box.x1, 6);
  EXPECT_EQ(box.y1, 10);
  box.include(3, 8);  // Inside already.
  EXPECT_EQ(box.width(), 4);
  EXPECT_EQ(box.height(), 3);
}

TEST(PixelBox, IsEmptyWhenEitherSideIsZero) {
  EXPECT_TRUE((PixelBox{1, 1, 1, 5}).empty());
  EXPECT_TRUE((PixelBox{1, 1, 5, 1}).empty());
  EXPECT_TRUE((PixelBox{5, 1, 1, 5}).empty());
  EXPECT_FALSE((PixelBox{1, 1, 2, 2}).empty());
}

TEST(PixelBox, ItsCentreIsThatOfItsPixels) {
  const PixelBox box{2, 3, 5, 7};
  EXPECT_EQ(box.center_x(), 3.0);
  EXPECT_EQ(box.center_y(), 4.5);
}

TEST(PixelBox, TouchesTheBorderWithAnySide) {
  EXPECT_FALSE((PixelBox{1, 1, 9, 7}).touches_border(10, 8));
  EXPECT_TRUE((PixelBox{0, 1, 9, 7}).touches_border(10, 8));
  EXPECT_TRUE((PixelBox{1, 0, 9, 7}).touches_border(10, 8));
  EXPECT_TRUE((PixelBox{1, 1, 10, 7}).touches_border(10, 8));
  EXPECT_TRUE((PixelBox{1, 1, 9, 8}).touches_border(10, 8));
}

}  // namespace
}  // namespace kinetrace

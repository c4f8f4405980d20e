#include "mask_membership.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::features {
namespace {

constexpr int kWidth = 80;
constexpr int kHeight = 40;
constexpr std::uint8_t kOwn = 1;
constexpr std::uint8_t kOther = 2;

/// Columns [20, 50) are body 1; from column 50 on the label is `beyond`.
class Masks {
 public:
  explicit Masks(std::uint8_t beyond) : pixels_(std::size_t{kWidth} * kHeight, kBackgroundLabel) {
    for (int y = 0; y < kHeight; ++y) {
      std::fill_n(pixels_.begin() + y * kWidth + 20, 30, kOwn);
      std::fill_n(pixels_.begin() + y * kWidth + 50, kWidth - 50, beyond);
    }
  }
  [[nodiscard]] LabelView view() const { return {pixels_.data(), kWidth, kHeight, kWidth}; }

 private:
  std::vector<std::uint8_t> pixels_;
};

TEST(MaskMembership, HoldsWellInsideABody) {
  EXPECT_TRUE(well_inside(Masks(kOther).view(), {35.F, 20.F}, kOwn));
}

TEST(MaskMembership, RefusesPatchesThatReachIntoAnotherObject) {
  EXPECT_FALSE(clear_of_other_objects(Masks(kOther).view(), {46.F, 20.F}, kOwn));
  EXPECT_TRUE(clear_of_other_objects(Masks(kOther).view(), {43.F, 20.F}, kOwn));
  EXPECT_TRUE(clear_of_other_objects(Masks(kBackgroundLabel).view(), {46.F, 20.F}, kOwn));
}

TEST(MaskMembership, AllowsPatchesOnTheOutlineAgainstTheBackground) {
  EXPECT_TRUE(well_inside(Masks(kBackgroundLabel).view(), {48.F, 20.F}, kOwn));
}

TEST(MaskMembership, RefusesAThinPieceOfABody) {
  std::vector<std::uint8_t> pixels(std::size_t{kWidth} * kHeight, kBackgroundLabel);
  pixels[20 * kWidth + 35] = kOwn;
  EXPECT_FALSE(well_inside({pixels.data(), kWidth, kHeight, kWidth}, {35.F, 20.F}, kOwn));
}

TEST(MaskMembership, AsksNothingOfTheBackground) {
  EXPECT_TRUE(well_inside(Masks(kOther).view(), {51.F, 20.F}, kBackgroundLabel));
  EXPECT_TRUE(clear_of_other_objects(Masks(kOther).view(), {51.F, 20.F}, kBackgroundLabel));
}

TEST(MaskMembership, KeepsABodyNearItsBorderAndEndsOnIgnored) {
  EXPECT_TRUE(still_member(Masks(kOther).view(), {51.F, 20.F}, kOwn, 2.F));
  EXPECT_FALSE(still_member(Masks(kOther).view(), {56.F, 20.F}, kOwn, 2.F));
  EXPECT_FALSE(still_member(Masks(kIgnoreLabel).view(), {51.F, 20.F}, kOwn, 2.F));
}

// A patch at (x + .5, y) holds the columns x - 7 to x + 8 and the rows y - 5 to y + 5.

void expect_rows(const PatchMask& mask, std::uint16_t columns) {
  EXPECT_FALSE(mask.whole);
  for (const std::uint16_t row : mask.rows) {
    EXPECT_EQ(row, columns);
  }
}

TEST(OwnPixels, AreAllOfThemInsideABody) {
  EXPECT_TRUE(own_pixels(Masks(kOther).view(), {35.5F, 20.F}, kOwn).whole);
  EXPECT_TRUE(own_pixels(Masks(kOther).view(), {65.5F, 20.F}, kOther).whole);
}

TEST(OwnPixels, EndOnePixelBeforeTheContour) {
  EXPECT_TRUE(own_pixels(Masks(kOther).view(), {40.5F, 20.F}, kOwn).whole) << "column 49 is beside the patch";
  expect_rows(own_pixels(Masks(kOther).view(), {41.5F, 20.F}, kOwn), 0x7FFF);
  for (const std::uint8_t beyond : {kOther, kBackgroundLabel, kIgnoreLabel}) {
    expect_rows(own_pixels(Masks(beyond).view(), {45.5F, 20.F}, kOwn), 0x07FF);
  }
  expect_rows(own_pixels(Masks(kOther).view(), {22.5F, 20.F}, kOwn), 0xFFC0);
}

TEST(OwnPixels, EndOneRowBeforeTheContour) {
  std::vector<std::uint8_t> pixels(std::size_t{kWidth} * kHeight, kOwn);
  std::fill(pixels.begin() + 22 * kWidth, pixels.end(), kOther);
  const PatchMask mask = own_pixels({pixels.data(), kWidth, kHeight, kWidth}, {35.5F, 20.F}, kOwn);
  EXPECT_FALSE(mask.whole);
  for (int row = 0; row < kPatchHeight; ++row) {
    EXPECT_EQ(mask.rows[row], row <= 5 ? 0xFFFF : 0) << row;
  }
}

TEST(OwnPixels, LeaveOutTheSurroundingsOfASingleIgnoredPixel) {
  std::vector<std::uint8_t> pixels(std::size_t{kWidth} * kHeight, kOwn);
  pixels[20 * kWidth + 35] = kIgnoreLabel;
  const PatchMask mask = own_pixels({pixels.data(), kWidth, kHeight, kWidth}, {35.5F, 20.F}, kOwn);
  EXPECT_FALSE(mask.whole);
  for (int row = 0; row < kPatchHeight; ++row) {
    EXPECT_EQ(mask.rows[row], row >= 4 && row <= 6 ? 0xFE3F : 0xFFFF) << row;
  }
}

TEST(OwnPixels, AreTheWholePatchWhereFewerThanAQuarterAreLeft) {
  expect_rows(own_pixels(Masks(kOther).view(), {52.5F, 20.F}, kOwn), 0x000F);
  EXPECT_TRUE(own_pixels(Masks(kOther).view(), {53.5F, 20.F}, kOwn).whole) << "three columns of sixteen";
  EXPECT_TRUE(own_pixels(Masks(kOther).view(), {70.5F, 20.F}, kOwn).whole) << "none";
}

TEST(OwnPixels, ContinueBeyondTheImageAsAtItsBorder) {
  const Masks masks(kOther);
  for (const float y : {0.F, 3.F, static_cast<float>(kHeight) - 1.F}) {
    EXPECT_TRUE(own_pixels(masks.view(), {2.5F, y}, kBackgroundLabel).whole) << y;
    EXPECT_TRUE(own_pixels(masks.view(), {78.5F, y}, kOther).whole) << y;
    expect_rows(own_pixels(masks.view(), {45.5F, y}, kOwn), 0x07FF);
  }
  // Columns -1 to 14 of a body that ends at column 10.
  std::vector<std::uint8_t> pixels(std::size_t{kWidth} * kHeight, kOther);
  for (int y = 0; y < kHeight; ++y) {
    std::fill_n(pixels.begin() + y * kWidth, 11, kOwn);
  }
  expect_rows(own_pixels({pixels.data(), kWidth, kHeight, kWidth}, {6.5F, 1.F}, kOwn), 0x07FF);
}

}  // namespace
}  // namespace kinetrace::features

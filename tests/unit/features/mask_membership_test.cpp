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

/// Columns [20, 50) are body 1; from column 50 on lies `beyond`.
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

}  // namespace
}  // namespace kinetrace::features

#include "mask_assembly.hpp"

#include <numeric>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::neural {
namespace {

constexpr int kInput = 64;

/// Two prototypes: the first is 1 in the left half and -1 in the right, the second everywhere 1.
class Assembly : public ::testing::Test {
 protected:
  Assembly() : values_(2 * kCells, 1.F) {
    for (std::size_t i = 0; i < kCells; ++i) {
      values_[i] = i % kGrid < kGrid / 2 ? 1.F : -1.F;
    }
    grid_ = {.values = values_, .sizes = {1, 2, kGrid, kGrid}, .rank = 4};
    layout_.mask_count = 2;
    layout_.mask_width = kGrid;
    layout_.mask_height = kGrid;
  }
  [[nodiscard]] bool add(const Box& box, const std::vector<float>& coefficients, int width = kInput,
                         int height = kInput) {
    ModelInput input;
    input.width_px = input.height_px = kInput;
    return assembly_.add({box, 0.9F, 0, {coefficients.data(), 1}}, kVehicleClass, layout_, grid_,
                         {width, height, {0, 0, width, height}, Placement::of(width, height, input)});
  }
  static std::size_t area(const RunLengthMask& mask) {
    std::size_t pixels = 0;
    for (std::size_t i = 1; i < mask.runs.size(); i += 2) {
      pixels += mask.runs[i];
    }
    return pixels;
  }

  static constexpr int kGrid = kInput / 4;
  static constexpr std::size_t kCells = std::size_t{kGrid} * kGrid;
  static constexpr GridSize kLargestGrid{kInput / 2, kInput / 2};
  std::vector<float> values_;
  Tensor grid_;
  HeadLayout layout_;
  Arena arena_{1 << 22};
  MaskAssembly assembly_{4, 1000, kLargestGrid, arena_};
};

TEST_F(Assembly, WeighsPrototypesAndCutsToTheBox) {
  ASSERT_TRUE(add({8, 8, 56, 24}, {1.F, 0.F}));
  ASSERT_EQ(assembly_.masks().size(), 1U);
  const RunLengthMask& mask = assembly_.masks()[0];
  EXPECT_TRUE(fits(mask, kInput, kInput));
  EXPECT_EQ(mask.box_px.x0, 8);
  EXPECT_EQ(mask.box_px.y1, 24);
  // From column 8 to the middle.
  EXPECT_EQ(area(mask), 24U * 16U);
}

TEST_F(Assembly, PrototypesOfHalfTheSizeAreTwiceAsFine) {
  // Every other column of cells, two pixels each.
  std::vector<float> stripes(std::size_t{kLargestGrid.width} * kLargestGrid.height);
  for (std::size_t i = 0; i < stripes.size(); ++i) {
    stripes[i] = i % 2 == 0 ? 1.F : -1.F;
  }
  grid_ = {.values = stripes, .sizes = {1, 1, kLargestGrid.height, kLargestGrid.width}, .rank = 4};
  layout_.mask_count = 1;
  layout_.mask_width = kLargestGrid.width;
  layout_.mask_height = kLargestGrid.height;
  layout_.prototype_stride_px = 2;
  ASSERT_TRUE(add({8, 8, 56, 24}, {1.F}));
  EXPECT_EQ(area(assembly_.masks()[0]), 24U * 16U) << "half of 48 columns";
  EXPECT_EQ(assembly_.masks()[0].runs.size(), 16U * 24U + 1U) << "of two pixels each";
}

TEST_F(Assembly, CoefficientsDecideWhatIsInside) {
  ASSERT_TRUE(add({8, 8, 56, 24}, {-1.F, 0.F}));
  ASSERT_TRUE(add({8, 8, 56, 24}, {1.F, 2.F}));
  EXPECT_EQ(area(assembly_.masks()[0]), 24U * 16U) << "the other half";
  EXPECT_EQ(area(assembly_.masks()[1]), 48U * 16U) << "all of it";
}

TEST_F(Assembly, AMaskWithoutAPixelIsLeftOut) {
  EXPECT_TRUE(add({8, 8, 56, 24}, {0.F, -1.F}));
  EXPECT_TRUE(add({-40, -40, -20, -20}, {0.F, 1.F}));
  EXPECT_TRUE(assembly_.masks().empty());
}

TEST_F(Assembly, BoxesBeyondThePictureAreCut) {
  ASSERT_TRUE(add({-20, -20, 200, 200}, {0.F, 1.F}));
  EXPECT_EQ(area(assembly_.masks()[0]), static_cast<std::size_t>(kInput * kInput));
}

TEST_F(Assembly, LargePicturesHaveLongRuns) {
  ASSERT_TRUE(add({0, 0, kInput, kInput}, {0.F, 1.F}, 640, 640));
  const RunLengthMask& mask = assembly_.masks()[0];
  EXPECT_TRUE(fits(mask, 640, 640)) << "409600 pixels in runs of 65535 at most";
  EXPECT_EQ(area(mask), 640U * 640U);
}

TEST_F(Assembly, InAPictureOfAnotherAspectItLiesWhereItIsSeen) {
  // 128 x 32: the picture fills the rows from 24 to 40 of the input.
  ASSERT_TRUE(add({0, 24, 64, 40}, {1.F, 0.F}, 128, 32));
  const RunLengthMask& mask = assembly_.masks()[0];
  EXPECT_EQ(mask.box_px.height(), 32);
  EXPECT_EQ(area(mask), 64U * 32U) << "the left half";
}

TEST_F(Assembly, WhatHasNoRoomIsRefusedAndNothingIsLost) {
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(add({8, 8, 56, 24}, {1.F, 0.F}));
  }
  EXPECT_FALSE(add({8, 8, 56, 24}, {1.F, 0.F})) << "a fifth mask";
  EXPECT_EQ(assembly_.masks().size(), 4U);
  assembly_.clear();
  MaskAssembly few_runs(4, 10, kLargestGrid, arena_);
  assembly_ = few_runs;
  EXPECT_FALSE(add({8, 8, 56, 24}, {1.F, 0.F})) << "one run a row";
  EXPECT_TRUE(assembly_.masks().empty());
  EXPECT_TRUE(add({8, 8, 56, 10}, {1.F, 0.F}));
}

TEST_F(Assembly, OfMaskRcnnTheGridFillsTheBox) {
  const std::vector<float> probabilities{0.9F, 0.1F, 0.9F, 0.1F};
  layout_.kind = HeadLayout::Kind::kDetections;
  layout_.mask_width = layout_.mask_height = 2;
  ASSERT_TRUE(add({16, 16, 48, 48}, probabilities));
  EXPECT_EQ(area(assembly_.masks()[0]), 16U * 32U);
}

}  // namespace
}  // namespace kinetrace::neural

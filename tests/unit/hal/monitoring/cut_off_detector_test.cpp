#include "kinetrace/hal/cut_off_detector.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::hal {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;

// Textured, with a few rows at the bottom of one value.
class Picture {
 public:
  explicit Picture(int flat_rows = 0, std::uint8_t value = 0) {
    for (int i = 0; i < kWidth * kHeight; ++i) {
      pixels_.push_back(static_cast<std::uint8_t>(1 + i * 37 % 251));
    }
    std::fill(pixels_.end() - static_cast<std::ptrdiff_t>(flat_rows) * kWidth, pixels_.end(), value);
  }
  /// Rows above the flat ones become darker towards them, as a shadow does.
  Picture& fade(int flat_rows) {
    for (int row = 0; row < 16; ++row) {
      const auto first = pixels_.end() - static_cast<std::ptrdiff_t>(flat_rows + 1 + row) * kWidth;
      std::for_each(first, first + kWidth, [row](std::uint8_t& pixel) {
        pixel = static_cast<std::uint8_t>(std::max(0, pixel / 16 - (16 - row)));
      });
    }
    return *this;
  }
  [[nodiscard]] GrayView view() const { return {pixels_.data(), kWidth, kHeight, kWidth}; }

 private:
  std::vector<std::uint8_t> pixels_;
};

class CutOff : public ::testing::Test {
 protected:
  /// Rows found missing of either view.
  int examine(const Picture& left, const Picture& right) {
    const auto finding = detector_.examine({0, 0, {}, left.view(), right.view()});
    return finding ? finding->rows : 0;
  }
  const Picture whole_;
  CutOffDetector detector_;
};

TEST_F(CutOff, TwoRowsAreEnough) {
  EXPECT_EQ(examine(whole_, whole_), 0);
  EXPECT_EQ(examine(Picture(1), whole_), 0);
  EXPECT_EQ(examine(Picture(2), whole_), 2);
  EXPECT_EQ(examine(whole_, Picture(9, 128)), 9);
  EXPECT_EQ(examine(whole_, whole_), 0);
}

TEST_F(CutOff, SaysWhichView) {
  ASSERT_FALSE(detector_.examine({0, 0, {}, whole_.view(), whole_.view()}));
  const Picture cut(20);
  EXPECT_TRUE(detector_.examine({1, 0, {}, cut.view(), whole_.view()})->is_left);
  EXPECT_FALSE(detector_.examine({2, 0, {}, whole_.view(), cut.view()})->is_left);
}

TEST_F(CutOff, ABorderThatIsAlwaysThereIsNone) {
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(examine(Picture(10), Picture(4)), 0) << i;
  }
  EXPECT_EQ(examine(Picture(12), Picture(4)), 12) << "two rows more than the border";
  detector_ = {};
  EXPECT_EQ(examine(Picture(10), Picture(10)), 0);
  EXPECT_EQ(examine(Picture(10), whole_), 0) << "whatever the other view sees there";
}

TEST_F(CutOff, ADamagedFirstFrameDoesNotHideTheNext) {
  EXPECT_EQ(examine(Picture(10), whole_), 0) << "nothing to compare it with";
  EXPECT_EQ(examine(whole_, whole_), 0);
  EXPECT_EQ(examine(Picture(10), whole_), 10);
}

TEST_F(CutOff, AThirdIsDamageInEveryFrame) {
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(examine(Picture(kHeight / 3), whole_), kHeight / 3) << i;
    EXPECT_EQ(examine(whole_, Picture(kHeight)), kHeight) << i;
  }
}

TEST_F(CutOff, WhatNeitherCameraSeesIsNone) {
  ASSERT_EQ(examine(whole_, whole_), 0);
  EXPECT_EQ(examine(Picture(20), Picture(20)), 0);
  EXPECT_EQ(examine(Picture(20, 255), Picture(18, 253)), 20) << "two rows that the other view sees";
  EXPECT_EQ(examine(Picture(20, 255), Picture(19, 253)), 0);
}

TEST_F(CutOff, AShadowFadesIn) {
  ASSERT_EQ(examine(whole_, whole_), 0);
  EXPECT_EQ(examine(Picture(8).fade(8), whole_), 0);
}

}  // namespace
}  // namespace kinetrace::hal

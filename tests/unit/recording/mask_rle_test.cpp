#include "mask_rle.hpp"

#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "run_readers.hpp"
#include "synthetic_run.hpp"

namespace kinetrace::recording {
namespace {

/// A label image with the encoder's and the test decoder's view of one label.
class MaskRle : public ::testing::Test {
 protected:
  MaskRle() : buffer_(4096) {}

  void resize(int width, int height) {
    width_ = width;
    height_ = height;
    pixels_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
  }
  std::uint8_t& at(int x, int y) {
    return pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
  }
  LabelView view() { return {pixels_.data(), width_, height_, width_}; }
  std::string encode(std::uint8_t label, PixelBox box) {
    const std::filesystem::path path = folder_.path() / "rle";
    Result<BufferedWriter> out = BufferedWriter::create(path, buffer_);
    write_mask_rle(view(), box, label, *out);
    EXPECT_TRUE(out->close());
    return read_text(path);
  }
  std::string encode(std::uint8_t label) { return encode(label, {0, 0, width_, height_}); }
  std::vector<std::uint8_t> mask_of(std::uint8_t label) const {
    std::vector<std::uint8_t> mask;
    for (const std::uint8_t pixel : pixels_) {
      mask.push_back(pixel == label ? 1 : 0);
    }
    return mask;
  }

  TemporaryFolder folder_;
  std::vector<std::byte> buffer_;
  std::vector<std::uint8_t> pixels_;
  int width_ = 0;
  int height_ = 0;
};

TEST_F(MaskRle, WritesCountsByHand) {
  // Columns of 3: 000 | 010 | 110 -> counts 4 1 1 2 1; stored 4 1 1, then 2 - 1 = 1 and 1 - 1 = 0.
  resize(3, 3);
  at(1, 1) = at(2, 0) = at(2, 1) = 5;
  EXPECT_EQ(encode(5), "41110");
}

TEST_F(MaskRle, SplitsLargeAndNegativeNumbersIntoGroups) {
  // Counts 0 2000 for a full image: 2000 = 0b1_11110_10000 -> groups 16+32, 30+32, 1 -> characters 96, 110, 49.
  resize(50, 40);
  pixels_.assign(pixels_.size(), 1);
  EXPECT_EQ(encode(1), "0`n1");
  // Counts 0 40 1 1 1958: 1 - 40 = -39 = ...11110_11001 -> 25+32, 30 -> 'i' 'N'; 1958 - 1 = 1957 -> 5+32, 29+32, 1.
  pixels_.assign(pixels_.size(), 0);
  for (int y = 0; y < 40; ++y) {
    at(0, y) = 1;
  }
  at(1, 1) = 1;
  EXPECT_EQ(encode(1), std::string("0X11iNUm1"));
}

TEST_F(MaskRle, RoundTripsSingleColumnRowPixelAndCorner) {
  for (const auto& [width, height] : {std::pair{1, 9}, std::pair{9, 1}, std::pair{1, 1}, std::pair{7, 5}}) {
    resize(width, height);
    at(width - 1, height - 1) = 3;
    EXPECT_EQ(decode_rle(encode(3), width, height), mask_of(3));
    at(0, 0) = 3;
    EXPECT_EQ(decode_rle(encode(3), width, height), mask_of(3));
  }
}

TEST_F(MaskRle, RoundTripsRandomMasksOfAllDensities) {
  std::mt19937 random(3);
  for (const int percent : {1, 20, 50, 80, 99}) {
    resize(67, 41);
    for (std::uint8_t& pixel : pixels_) {
      pixel = static_cast<int>(random() % 100) < percent ? 9 : static_cast<std::uint8_t>(random() % 3);
    }
    EXPECT_EQ(decode_rle(encode(9), width_, height_), mask_of(9)) << percent;
  }
}

TEST_F(MaskRle, JoinsRunsAcrossColumnsOfFullHeight) {
  resize(20, 10);
  for (int x = 4; x < 8; ++x) {
    for (int y = 0; y < 10; ++y) {
      at(x, y) = 2;
    }
  }
  EXPECT_EQ(encode(2), "X1X1h3") << "40 zeros, 40 ones, 120 zeros";
}

TEST_F(MaskRle, LooksOnlyIntoTheBoxAndClipsIt) {
  resize(30, 20);
  at(5, 5) = at(25, 15) = 4;
  std::vector<std::uint8_t> expected(pixels_.size());
  expected[5 * 30 + 5] = 1;
  EXPECT_EQ(decode_rle(encode(4, {-3, -3, 10, 100}), 30, 20), expected);
  EXPECT_TRUE(has_label(view(), {25, 15, 26, 16}, 4));
  EXPECT_FALSE(has_label(view(), {26, 15, 99, 16}, 4));
  EXPECT_FALSE(has_label(view(), {40, 40, 50, 50}, 4));
}

TEST_F(MaskRle, AnEmptyMaskIsOneRunOfBackground) {
  resize(4, 4);
  EXPECT_EQ(encode(1), "`0");
  EXPECT_EQ(decode_rle("`0", 4, 4), mask_of(1));
}

}  // namespace
}  // namespace kinetrace::recording

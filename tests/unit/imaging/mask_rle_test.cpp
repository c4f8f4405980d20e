#include "kinetrace/imaging/mask_rle.hpp"

#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::imaging {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A label image, the encoder's text of one label, and the pixels that the decoder's runs name.
class MaskRle : public ::testing::Test {
 protected:
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
    std::string text;
    encode_mask_rle(view(), box, label, [&](std::string_view piece) { text += piece; });
    return text;
  }
  std::string encode(std::uint8_t label) { return encode(label, {0, 0, width_, height_}); }
  std::vector<std::uint8_t> decode(const std::string& text) const {
    const Result<std::vector<MaskRun>> runs = decode_mask_rle(text, width_, height_);
    EXPECT_TRUE(runs) << runs.error().message;
    std::vector<std::uint8_t> mask(pixels_.size());
    for (const MaskRun& run : runs.value_or(std::vector<MaskRun>{})) {
      for (std::int64_t i = run.begin; i < run.end; ++i) {
        mask[static_cast<std::size_t>(i % height_ * width_ + i / height_)] = 1;
      }
    }
    return mask;
  }
  std::vector<std::uint8_t> mask_of(std::uint8_t label) const {
    std::vector<std::uint8_t> mask;
    for (const std::uint8_t pixel : pixels_) {
      mask.push_back(pixel == label ? 1 : 0);
    }
    return mask;
  }

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

TEST_F(MaskRle, ReadsCountsByHand) {
  const auto runs = [](std::string_view text, int width, int height) { return *decode_mask_rle(text, width, height); };
  EXPECT_THAT(runs("41110", 3, 3), ElementsAre(MaskRun{4, 5}, MaskRun{6, 8}));
  EXPECT_THAT(runs("0`n1", 50, 40), ElementsAre(MaskRun{0, 2000}));
  EXPECT_THAT(runs("0X11iNUm1", 50, 40), ElementsAre(MaskRun{0, 40}, MaskRun{41, 42}));
  EXPECT_THAT(runs("9", 3, 3), IsEmpty());
  EXPECT_THAT(runs("4014O", 3, 3), ElementsAre(MaskRun{5, 9})) << "a run of no pixels";
}

TEST_F(MaskRle, RoundTripsSingleColumnRowPixelAndCorner) {
  for (const auto& [width, height] : {std::pair{1, 9}, std::pair{9, 1}, std::pair{1, 1}, std::pair{7, 5}}) {
    resize(width, height);
    at(width - 1, height - 1) = 3;
    EXPECT_EQ(decode(encode(3)), mask_of(3));
    at(0, 0) = 3;
    EXPECT_EQ(decode(encode(3)), mask_of(3));
  }
}

TEST_F(MaskRle, RoundTripsRandomMasksOfAllDensities) {
  std::mt19937 random(3);
  for (const int percent : {1, 20, 50, 80, 99}) {
    resize(67, 41);
    for (std::uint8_t& pixel : pixels_) {
      pixel = static_cast<int>(random() % 100) < percent ? 9 : static_cast<std::uint8_t>(random() % 3);
    }
    EXPECT_EQ(decode(encode(9)), mask_of(9)) << percent;
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
  EXPECT_EQ(decode(encode(4, {-3, -3, 10, 100})), expected);
  EXPECT_TRUE(has_label(view(), {25, 15, 26, 16}, 4));
  EXPECT_FALSE(has_label(view(), {26, 15, 99, 16}, 4));
  EXPECT_FALSE(has_label(view(), {40, 40, 50, 50}, 4));
}

TEST_F(MaskRle, AnEmptyMaskIsOneRunOfBackground) {
  resize(4, 4);
  EXPECT_EQ(encode(1), "`0");
  EXPECT_EQ(decode("`0"), mask_of(1));
}

struct Malformed {
  std::string text;
  std::string reason;
};

TEST_F(MaskRle, RefusesMalformedStringsAndSaysWhere) {
  for (const auto& [text, reason] :
       std::vector<Malformed>{{"", "fewer pixels"},                            // no run at all
                              {"4111", "character 5: fewer pixels"},           // 8 of 9
                              {"41112", "character 5: more pixels"},           // 11 of 9
                              {":", "more pixels"},                            // 10 of 9
                              {"411 0", "character 4: no character"},          // blank
                              {"41\xC3\xB6", "character 3: no character"},     // outside ASCII
                              {"p", "character 1: no character"},              // one past the alphabet
                              {"/", "character 1: no character"},              // one before it
                              {"4111P", "character 6: ends within a number"},  // more bits announced
                              {"4111N", "character 5: negative length"},       // 1 - 2
                              {"O", "character 1: negative length"},           // -1
                              {std::string(12, 'P') + "0", "number beyond 60 bits"},
                              {std::string(1000, 'o'), "number beyond 60 bits"}}) {
    const auto runs = decode_mask_rle(text, 3, 3);
    ASSERT_FALSE(runs) << text;
    EXPECT_EQ(runs.error().code, ErrorCode::kBadFormat);
    EXPECT_THAT(runs.error().message, HasSubstr(reason)) << text;
  }
}

TEST_F(MaskRle, RefusesImagesWithoutPixelsAndTakesLargeOnes) {
  EXPECT_EQ(decode_mask_rle("0", 0, 3).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(decode_mask_rle("0", 3, -1).error().code, ErrorCode::kInvalidArgument);
  constexpr int kSide = 60'000;
  constexpr std::int64_t kPixels = std::int64_t{kSide} * kSide;
  RunLengthEncoder encoder;
  const std::string none(encoder.next(0));
  const auto runs = decode_mask_rle(none + std::string(encoder.next(kPixels)), kSide, kSide);
  ASSERT_TRUE(runs) << runs.error().message;
  EXPECT_THAT(*runs, ElementsAre(MaskRun{0, kPixels}));
}

}  // namespace
}  // namespace kinetrace::imaging

#include "kinetrace/imaging/jpeg_decoder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "encode_for_test.hpp"

namespace kinetrace::imaging {
namespace {

using test::Bytes;

constexpr int kWidth = 24;
constexpr int kHeight = 16;

class JpegDecoding : public ::testing::Test {
 protected:
  Status decode(const Bytes& bytes) {
    return decoder_.decode_gray("camera", bytes, {pixels_.data(), kWidth, kHeight, kWidth});
  }
  /// A picture with so much detail that its last row takes many bytes.
  static Bytes detailed() {
    Bytes pixels(kWidth * kHeight);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      pixels[i] = static_cast<std::uint8_t>(i * i * 37);
    }
    return test::encode_jpeg_gray(kWidth, kHeight, pixels);
  }
  static Bytes with_stray_bytes(std::size_t count) {
    Bytes bytes = detailed();
    bytes.insert(bytes.end() - 2, count, 0x00);
    return bytes;
  }

  JpegDecoder decoder_ = JpegDecoder::create().value();
  Bytes pixels_ = Bytes(kWidth * kHeight);
};

TEST_F(JpegDecoding, ReadsLuminance) {
  ASSERT_TRUE(decode(test::encode_jpeg_gray(kWidth, kHeight, Bytes(kWidth * kHeight, 90))));
  for (const int pixel : pixels_) {
    EXPECT_NEAR(pixel, 90, 1);
  }
}

TEST_F(JpegDecoding, AFewStrayBytesBeforeTheEndAreNoDamage) {
  ASSERT_TRUE(decode(detailed()));
  const Bytes expected = pixels_;
  for (const std::size_t count : {1U, 2U, 16U}) {
    std::fill(pixels_.begin(), pixels_.end(), std::uint8_t{0});
    const Status decoded = decode(with_stray_bytes(count));
    ASSERT_TRUE(decoded) << count << ": " << decoded.error().message;
    EXPECT_EQ(pixels_, expected) << count;
  }
}

// The decoder reads a few bytes ahead and does not count those.
TEST_F(JpegDecoding, ManyStrayBytesAreDamage) {
  const Status decoded = decode(with_stray_bytes(32));
  ASSERT_FALSE(decoded);
  EXPECT_EQ(decoded.error().code, ErrorCode::kBadFormat);
}

TEST_F(JpegDecoding, WhatIsCutIsDamagedAndNamed) {
  const Bytes whole = detailed();
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, whole.size() / 2, whole.size() - 10}) {
    const Status decoded = decode(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    ASSERT_FALSE(decoded) << size;
    EXPECT_EQ(decoded.error().code, ErrorCode::kBadFormat);
    EXPECT_THAT(decoded.error().message, ::testing::StartsWith("camera: "));
  }
}

TEST_F(JpegDecoding, ColoursOfPrintingAreNoDamage) {
  const Status decoded = decode(test::encode_jpeg_cmyk(kWidth, kHeight, Bytes(4 * kWidth * kHeight, 90)));
  ASSERT_FALSE(decoded);
  EXPECT_EQ(decoded.error().code, ErrorCode::kBadFormat);
  EXPECT_EQ(decoded.error().message, "camera: is a JPEG in CMYK, the colours of printing; convert it to RGB");
}

TEST_F(JpegDecoding, AnotherSizeIsRefusedAndBothArePrinted) {
  const Status decoded = decode(test::encode_jpeg_gray(kWidth + 8, kHeight, Bytes((kWidth + 8) * kHeight)));
  ASSERT_FALSE(decoded);
  EXPECT_EQ(decoded.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(decoded.error().message, ::testing::HasSubstr("32x16 pixels, expected 24x16"));
}

}  // namespace
}  // namespace kinetrace::imaging

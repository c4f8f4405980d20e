#include "kinetrace/imaging/image_reader.hpp"

#include <algorithm>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "encode_for_test.hpp"
#include "temp_folder.hpp"

namespace kinetrace::imaging {
namespace {

using test::Bytes;
using ::testing::HasSubstr;

constexpr int kWidth = 13;  // Neither is a multiple of 8: the last Adam7 columns and rows are partial.
constexpr int kHeight = 11;
constexpr int kPixels = kWidth * kHeight;

ImageReaderConfig small_config() {
  return {.max_width_px = 64, .max_height_px = 64, .max_file_bytes = 1 << 16};
}

Bytes ramp(int bytes) {
  Bytes pixels(static_cast<std::size_t>(bytes));
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] = static_cast<std::uint8_t>(i * 37 + i / 7);
  }
  return pixels;
}

std::uint8_t rec601(int r, int g, int b) {
  return static_cast<std::uint8_t>((77 * r + 150 * g + 29 * b + 128) >> 8);
}

class Reading : public ::testing::Test {
 protected:
  Status read_gray(const Bytes& bytes) {
    test::write_file(path_, bytes);
    return reader_.read_gray(path_.c_str(), gray_);
  }
  Status read_gray16(const Bytes& bytes) {
    test::write_file(path_, bytes);
    return reader_.read_gray16(path_.c_str(), gray16_);
  }
  // Checks every pixel against expected(i), i counting in rows.
  void expect_gray(const Bytes& bytes, const std::function<int(std::size_t)>& expected, int tolerance = 0) {
    const Status status = read_gray(bytes);
    ASSERT_TRUE(status) << status.error().message;
    for (int i = 0; i < kPixels; ++i) {
      ASSERT_NEAR(gray_.at(i % kWidth, i / kWidth), expected(static_cast<std::size_t>(i)), tolerance) << "pixel " << i;
    }
  }
  void expect_refused(const Bytes& bytes, ErrorCode code, const char* what) {
    const Status status = read_gray(bytes);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, code) << status.error().message;
    EXPECT_THAT(status.error().message, HasSubstr(path_));
    EXPECT_THAT(status.error().message, HasSubstr(what));
    EXPECT_THAT(status.error().message, Not(HasSubstr("\n")));
  }

  kinetrace::test::TempFolder folder_;
  std::string path_ = folder_.file("image");
  Arena arena_{std::size_t{1} << 20};
  ImageReader reader_ = ImageReader::create(small_config(), arena_).value();
  MutableGrayView gray_ = take_image<std::uint8_t>(arena_, kWidth, kHeight);
  ImageView<std::uint16_t> gray16_ = take_image<std::uint16_t>(arena_, kWidth, kHeight);
};

class ReadingPng : public Reading, public ::testing::WithParamInterface<bool> {
 protected:
  Bytes png(std::uint8_t color_type, std::uint8_t bit_depth, const Bytes& pixels) {
    return test::encode_png({color_type, bit_depth, GetParam()}, kWidth, kHeight, pixels);
  }
};
INSTANTIATE_TEST_SUITE_P(PlainAndInterlaced, ReadingPng, ::testing::Values(false, true));

std::uint16_t sample16(const Bytes& pixels, std::size_t i) {
  std::uint16_t value = 0;
  std::memcpy(&value, &pixels[2 * i], 2);
  return value;
}

TEST_P(ReadingPng, GrayOfEightBitsComesUnchanged) {
  const Bytes pixels = ramp(kPixels);
  expect_gray(png(0, 8, pixels), [&](std::size_t i) { return pixels[i]; });
}

TEST_P(ReadingPng, GrayOfSixteenBitsKeepsTheUpperByte) {
  const Bytes pixels = ramp(2 * kPixels);
  expect_gray(png(0, 16, pixels), [&](std::size_t i) { return sample16(pixels, i) >> 8; });
}

TEST_P(ReadingPng, GrayOfTwelveBitsInSixteenIsKnownByItsValues) {
  Bytes pixels = ramp(2 * kPixels);
  for (std::size_t i = 1; i < pixels.size(); i += 2) {
    pixels[i] &= 0x0F;  // The upper byte of a sample.
  }
  const Bytes file = png(0, 16, pixels);
  test::write_file(path_, file);
  EXPECT_EQ(reader_.used_bits(path_.c_str()).value(), 12);
  ASSERT_TRUE(reader_.read_gray(path_.c_str(), gray_, 12));
  for (int i = 0; i < kPixels; ++i) {
    ASSERT_EQ(gray_.at(i % kWidth, i / kWidth), sample16(pixels, static_cast<std::size_t>(i)) >> 4);
  }
  ASSERT_TRUE(reader_.read_gray(path_.c_str(), gray_, 10));
  for (int i = 0; i < kPixels; ++i) {
    ASSERT_EQ(gray_.at(i % kWidth, i / kWidth), std::min(sample16(pixels, static_cast<std::size_t>(i)) >> 2, 255));
  }
  test::write_file(path_, png(0, 16, ramp(2 * kPixels)));
  EXPECT_EQ(reader_.used_bits(path_.c_str()).value(), 16);
  test::write_file(path_, png(0, 8, Bytes(kPixels, 1)));
  EXPECT_EQ(reader_.used_bits(path_.c_str()).value(), 16) << "eight bits are what the file says";
}

TEST_P(ReadingPng, ColourBecomesRec601Luma) {
  const Bytes pixels = ramp(3 * kPixels);
  expect_gray(png(2, 8, pixels),
              [&](std::size_t i) { return rec601(pixels[3 * i], pixels[3 * i + 1], pixels[3 * i + 2]); });
}

TEST_P(ReadingPng, ColourOfSixteenBits) {
  const Bytes pixels = ramp(6 * kPixels);
  expect_gray(
      png(2, 16, pixels),
      [&](std::size_t i) {
        return rec601(sample16(pixels, 3 * i) >> 8, sample16(pixels, 3 * i + 1) >> 8, sample16(pixels, 3 * i + 2) >> 8);
      },
      1);
}

TEST_P(ReadingPng, AlphaIsIgnored) {
  const Bytes rgba = ramp(4 * kPixels);
  expect_gray(png(6, 8, rgba), [&](std::size_t i) { return rec601(rgba[4 * i], rgba[4 * i + 1], rgba[4 * i + 2]); });
  const Bytes gray_alpha = ramp(2 * kPixels);
  expect_gray(png(4, 8, gray_alpha), [&](std::size_t i) { return gray_alpha[2 * i]; });
  const Bytes gray_alpha16 = ramp(4 * kPixels);
  expect_gray(png(4, 16, gray_alpha16), [&](std::size_t i) { return sample16(gray_alpha16, 2 * i) >> 8; });
}

TEST_P(ReadingPng, PaletteIsLookedUp) {
  const Bytes pixels = ramp(kPixels);
  expect_gray(png(3, 8, pixels),
              [&](std::size_t i) { return rec601(pixels[i], 2 * pixels[i] % 256, 255 - pixels[i]); });
}

TEST_P(ReadingPng, LabelsOfSixteenBitsAreExact) {
  const Bytes pixels = ramp(2 * kPixels);
  const Status status = read_gray16(png(0, 16, pixels));
  ASSERT_TRUE(status) << status.error().message;
  for (std::size_t i = 0; i < kPixels; ++i) {
    ASSERT_EQ(gray16_.at(static_cast<int>(i) % kWidth, static_cast<int>(i) / kWidth), sample16(pixels, i));
  }
}

TEST_P(ReadingPng, LabelsOfEightBitsAreNotScaled) {
  const Bytes pixels = ramp(kPixels);
  ASSERT_TRUE(read_gray16(png(0, 8, pixels)));
  EXPECT_EQ(gray16_.at(3, 0), pixels[3]);
  EXPECT_EQ(gray16_.at(kWidth - 1, kHeight - 1), pixels[kPixels - 1]);
}

TEST_F(Reading, PngOfFewBitsIsScaledToTheFullRange) {
  // One bit per pixel, two bytes per row of 13 pixels.
  Bytes packed(2 * kHeight, 0);
  packed[0] = 0b01000000;
  expect_gray(test::encode_png({0, 1, false}, kWidth, kHeight, packed), [](std::size_t i) { return i == 1 ? 255 : 0; });
}

TEST_F(Reading, PgmOfEightAndSixteenBits) {
  const auto pgm = [](const char* header, const Bytes& pixels) {
    Bytes bytes(header, header + std::strlen(header));
    bytes.insert(bytes.end(), pixels.begin(), pixels.end());
    return bytes;
  };
  const Bytes pixels = ramp(kPixels);
  expect_gray(pgm("P5 13 11 255\n", pixels), [&](std::size_t i) { return pixels[i]; });
  const Bytes wide = ramp(2 * kPixels);
  expect_gray(pgm("P5\n#x\n13 11\n65535\n", wide), [&](std::size_t i) { return wide[2 * i]; });
  Bytes ten_bits(2 * kPixels, 0);
  ten_bits[0] = 1023 >> 8;
  ten_bits[1] = 1023 & 255;
  expect_gray(pgm("P5 13 11 1023\n", ten_bits), [](std::size_t i) { return i == 0 ? 255 : 0; });
  EXPECT_EQ(reader_.used_bits(path_.c_str()).value(), 16) << "its maxval says what is white";
  test::write_file(path_, pgm("P5 13 11 65535\n", ten_bits));
  EXPECT_EQ(reader_.used_bits(path_.c_str()).value(), 10);
  ASSERT_TRUE(reader_.read_gray(path_.c_str(), gray_, 10));
  EXPECT_EQ(gray_.at(0, 0), 255);
  ASSERT_TRUE(read_gray16(pgm("P5 13 11 65535\n", wide)));
  EXPECT_EQ(gray16_.at(1, 0), wide[2] << 8 | wide[3]);
  expect_refused(pgm("P5 13 11 255\n", ramp(kPixels - 1)), ErrorCode::kBadFormat, "truncated");
}

TEST_F(Reading, JpegGrayAndColour) {
  const Bytes flat(kPixels, 90);
  expect_gray(
      test::encode_jpeg_gray(kWidth, kHeight, flat), [](std::size_t) { return 90; }, 1);
  Bytes orange;
  for (int i = 0; i < kPixels; ++i) {
    orange.insert(orange.end(), {200, 120, 30});
  }
  expect_gray(
      test::encode_jpeg_rgb(kWidth, kHeight, orange), [](std::size_t) { return rec601(200, 120, 30); }, 2);
}

TEST_F(Reading, PngCutAnywhereIsNeverTakenForWhole) {
  const Bytes pixels = ramp(kPixels);
  const Bytes whole = test::encode_png({0, 8, false}, kWidth, kHeight, pixels);
  constexpr std::size_t kEndChunk = 12;  // IEND carries no pixels: cut within it, the image may still be whole.
  for (std::size_t size = 0; size < whole.size() - kEndChunk; ++size) {
    const Status status = read_gray(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    ASSERT_FALSE(status) << "cut to " << size << " of " << whole.size() << " bytes";
    EXPECT_EQ(status.error().code, ErrorCode::kBadFormat) << status.error().message;
  }
}

TEST_F(Reading, PngWithOneFlippedByteIsNeverTakenForWhole) {
  const Bytes pixels = ramp(kPixels);
  const Bytes whole = test::encode_png({0, 8, false}, kWidth, kHeight, pixels);
  for (std::size_t i = 0; i < whole.size() - 12; ++i) {
    Bytes damaged = whole;
    damaged[i] ^= 0x55;
    EXPECT_FALSE(read_gray(damaged)) << "byte " << i;
  }
}

TEST_F(Reading, JpegCutAnywhereIsAnError) {
  const Bytes pixels = ramp(kPixels);
  const Bytes whole = test::encode_jpeg_gray(kWidth, kHeight, pixels);
  for (std::size_t size = 0; size + 2 < whole.size(); ++size) {
    const Status status = read_gray(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    ASSERT_FALSE(status) << "cut to " << size << " of " << whole.size() << " bytes";
  }
  expect_refused(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.size() / 2 + 100)),
                 ErrorCode::kBadFormat, "truncated");
}

TEST_F(Reading, WrongSizeNamesBothSizes) {
  expect_refused(test::encode_png({0, 8, false}, kWidth + 1, kHeight, ramp(kPixels + kHeight)),
                 ErrorCode::kInvalidArgument, "14x11 pixels, expected 13x11");
}

TEST_F(Reading, HugeHeaderIsRefusedBeforeDecoding) {
  Bytes png = test::encode_png({0, 8, false}, kWidth, kHeight, ramp(kPixels));
  png[16] = 0x70;
  expect_refused(png, ErrorCode::kBadFormat, "its header claims 1879048205x11 pixels");
}

TEST_F(Reading, LargerThanTheReaderIsRefusedByItsHeader) {
  test::write_file(path_, test::encode_png({0, 8, false}, kWidth, kHeight, ramp(kPixels)));
  EXPECT_TRUE(reader_.inspect(path_.c_str()));
  const int side = small_config().max_width_px + 1;
  test::write_file(path_, test::encode_png({0, 8, false}, side, 1, ramp(static_cast<std::size_t>(side))));
  const Result<ImageInfo> refused = reader_.inspect(path_.c_str());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBadFormat);
  EXPECT_THAT(refused.error().message, HasSubstr(path_ + ": is " + std::to_string(side) + "x1 pixels, at most"));
}

TEST_F(Reading, FileAtTheLimitIsReadAndOneByteMoreIsRefused) {
  const std::string_view header = "P5 13 11 255\n";
  Bytes pgm(small_config().max_file_bytes, 7);
  std::copy(header.begin(), header.end(), pgm.begin());
  expect_gray(pgm, [](std::size_t) { return 7; });
  pgm.push_back(7);
  expect_refused(pgm, ErrorCode::kBadFormat, "are read of an image here");
}

TEST_F(Reading, LabelsRefuseColourAndJpeg) {
  const Status colour = read_gray16(test::encode_png({2, 8, false}, kWidth, kHeight, ramp(3 * kPixels)));
  ASSERT_FALSE(colour);
  EXPECT_EQ(colour.error().code, ErrorCode::kUnsupported);
  const Status jpeg = read_gray16(test::encode_jpeg_gray(kWidth, kHeight, ramp(kPixels)));
  ASSERT_FALSE(jpeg);
  EXPECT_EQ(jpeg.error().code, ErrorCode::kUnsupported);
}

TEST_F(Reading, GoodFileAfterABadOneIsRead) {
  const Bytes pixels = ramp(kPixels);
  const Bytes jpeg = test::encode_jpeg_gray(kWidth, kHeight, pixels);
  ASSERT_FALSE(read_gray(Bytes(jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(jpeg.size() - 20))));
  ASSERT_TRUE(read_gray(jpeg));
  expect_gray(test::encode_png({0, 8, false}, kWidth, kHeight, pixels), [&](std::size_t i) { return pixels[i]; });
}

TEST(ImageReader, TakesExactlyWhatItAnnounces) {
  Arena exact(ImageReader::required_bytes(small_config()));
  ASSERT_TRUE(ImageReader::create(small_config(), exact));
  EXPECT_EQ(exact.used_bytes(), ImageReader::required_bytes(small_config()));
  Arena small(ImageReader::required_bytes(small_config()) - Arena::kAlignment);
  const auto refused = ImageReader::create(small_config(), small);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kCapacity);
}

TEST(ImageReader, ValidatesItsConfiguration) {
  Arena arena(std::size_t{1} << 20);
  const auto code_of = [&arena](ImageReaderConfig config) {
    const auto reader = ImageReader::create(config, arena);
    return reader ? ErrorCode::kInternal : reader.error().code;
  };
  EXPECT_EQ(code_of({.max_width_px = 0}), ErrorCode::kInvalidConfig);
  EXPECT_EQ(code_of({.max_height_px = 16385}), ErrorCode::kInvalidConfig);
  EXPECT_EQ(code_of({.max_file_bytes = 1023}), ErrorCode::kInvalidConfig);
}

}  // namespace
}  // namespace kinetrace::imaging

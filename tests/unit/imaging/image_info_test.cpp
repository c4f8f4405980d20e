#include "kinetrace/imaging/image_info.hpp"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "encode_for_test.hpp"
#include "temp_folder.hpp"

namespace kinetrace::imaging {
namespace {

using test::Bytes;
using ::testing::HasSubstr;

Bytes text_bytes(const std::string& text) {
  return {text.begin(), text.end()};
}

class ReadImageInfo : public ::testing::Test {
 protected:
  Result<ImageInfo> info_of(const Bytes& bytes) {
    test::write_file(path_, bytes);
    return read_image_info(path_.c_str());
  }
  void expect_error(const Bytes& bytes, ErrorCode code, const char* what) {
    const Result<ImageInfo> info = info_of(bytes);
    ASSERT_FALSE(info);
    EXPECT_EQ(info.error().code, code);
    EXPECT_THAT(info.error().message, HasSubstr(path_));
    EXPECT_THAT(info.error().message, HasSubstr(what));
  }
  kinetrace::test::TempFolder folder_;
  std::string path_ = folder_.file("image");
};

// A JPEG of 20x10 pixels with an Exif segment whose only entry is the orientation (TIFF 6.0, section 2).
Bytes jpeg_with_orientation(int orientation, bool little_endian) {
  const auto number = [&](int value, std::size_t bytes) {
    Bytes encoded(bytes, 0);
    (little_endian ? encoded.front() : encoded.back()) = static_cast<std::uint8_t>(value);
    return encoded;
  };
  Bytes exif = text_bytes(little_endian ? "II" : "MM");
  const Bytes tag = little_endian ? Bytes{0x12, 0x01} : Bytes{0x01, 0x12};
  for (const Bytes& part : {number(42, 2), number(8, 4), number(1, 2), tag, number(3, 2), number(1, 4),
                            number(orientation, 2), Bytes(2), Bytes(4)}) {
    exif.insert(exif.end(), part.begin(), part.end());
  }
  Bytes jpeg = test::encode_jpeg_rgb(20, 10, Bytes(std::size_t{20} * 10 * 3));
  Bytes segment{0xFF, 0xE1, 0, static_cast<std::uint8_t>(2 + 6 + exif.size()), 'E', 'x', 'i', 'f', 0, 0};
  segment.insert(segment.end(), exif.begin(), exif.end());
  jpeg.insert(jpeg.begin() + 2, segment.begin(), segment.end());
  return jpeg;
}

TEST_F(ReadImageInfo, RefusesAnImageThatExifTurns) {
  for (const bool little_endian : {false, true}) {
    for (const int turned : {2, 6, 8}) {
      expect_error(jpeg_with_orientation(turned, little_endian), ErrorCode::kUnsupported,
                   "is turned or mirrored by its Exif orientation");
    }
    for (const int upright : {0, 1, 9}) {
      EXPECT_TRUE(info_of(jpeg_with_orientation(upright, little_endian))) << upright;
    }
  }
}

TEST_F(ReadImageInfo, DisregardsADamagedExifSegment) {
  const Bytes whole = jpeg_with_orientation(6, false);
  Bytes beyond = whole;
  beyond[19] = 200;  // Its directory lies beyond the segment.
  EXPECT_TRUE(info_of(beyond));
  Bytes other = whole;
  other[6] = 'X';  // "Xxif": another application's segment.
  EXPECT_TRUE(info_of(other));
}

TEST_F(ReadImageInfo, TellsPngPgmAndJpegByContent) {
  const Result<ImageInfo> png = info_of(test::encode_png({2, 16, false}, 5, 3, Bytes(std::size_t{5} * 3 * 6)));
  ASSERT_TRUE(png);
  EXPECT_EQ(png->format, ImageFormat::kPng);
  EXPECT_EQ(png->width, 5);
  EXPECT_EQ(png->height, 3);
  EXPECT_EQ(png->channels, 3);
  EXPECT_EQ(png->bit_depth, 16);

  const Result<ImageInfo> jpeg = info_of(test::encode_jpeg_rgb(20, 10, Bytes(std::size_t{20} * 10 * 3)));
  ASSERT_TRUE(jpeg);
  EXPECT_EQ(jpeg->format, ImageFormat::kJpeg);
  EXPECT_EQ(jpeg->width, 20);
  EXPECT_EQ(jpeg->height, 10);
  EXPECT_EQ(jpeg->channels, 3);
  EXPECT_EQ(jpeg->bit_depth, 8);

  const Result<ImageInfo> pgm = info_of(text_bytes("P5\n# a comment\n 7 2 # another\n65535\n"));
  ASSERT_TRUE(pgm);
  EXPECT_EQ(pgm->format, ImageFormat::kPgm);
  EXPECT_EQ(pgm->width, 7);
  EXPECT_EQ(pgm->height, 2);
  EXPECT_EQ(pgm->channels, 1);
  EXPECT_EQ(pgm->bit_depth, 16);
}

TEST_F(ReadImageInfo, NamesMissingEmptyAndForeignFiles) {
  const Result<ImageInfo> missing = read_image_info((path_ + ".none").c_str());
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(missing.error().message, HasSubstr(path_ + ".none"));
  expect_error({}, ErrorCode::kBadFormat, "empty (0 bytes)");
  expect_error(text_bytes("BM is a bitmap"), ErrorCode::kUnsupported, "convert it to PNG");
  const Result<ImageInfo> folder = read_image_info(folder_.path().c_str());
  ASSERT_FALSE(folder);
  EXPECT_EQ(folder.error().code, ErrorCode::kBadFormat);
}

TEST_F(ReadImageInfo, RejectsHeadersCutAnywhere) {
  const Bytes png = test::encode_png({0, 8, false}, 4, 4, Bytes(16));
  for (std::size_t size = 1; size < 26; ++size) {
    EXPECT_FALSE(info_of(Bytes(png.begin(), png.begin() + static_cast<std::ptrdiff_t>(size)))) << size;
  }
  const Bytes jpeg = test::encode_jpeg_gray(8, 8, Bytes(64));
  for (std::size_t size = 1; size < 40; ++size) {
    EXPECT_FALSE(info_of(Bytes(jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(size)))) << size;
  }
  expect_error(text_bytes("P5\n3"), ErrorCode::kBadFormat, "PGM header");
  expect_error(text_bytes("P5\n3 3 0\n"), ErrorCode::kBadFormat, "PGM header");
  expect_error(text_bytes("P5\n3 3 65536\n"), ErrorCode::kBadFormat, "PGM header");
  expect_error(text_bytes("P5\n-3 3 255\n"), ErrorCode::kBadFormat, "PGM header");
}

TEST_F(ReadImageInfo, RejectsImpossibleSizes) {
  Bytes png = test::encode_png({0, 8, false}, 4, 4, Bytes(16));
  png[16] = 0x7F;  // Width 2130706436.
  expect_error(png, ErrorCode::kBadFormat, "2130706436x4");
  png[16] = 0;
  png[19] = 0;
  expect_error(png, ErrorCode::kBadFormat, "0x4");
  expect_error(text_bytes("P5\n999999999 2\n255\n"), ErrorCode::kBadFormat, "999999999x2");
  expect_error(text_bytes("P5\n16385 2\n255\n"), ErrorCode::kBadFormat, "not within 1 to 16384");
}

TEST_F(ReadImageInfo, RejectsMorePixelsThanTheFileCanHold) {
  Bytes png = test::encode_png({0, 8, false}, 4, 4, Bytes(16));
  png[18] = png[22] = 0x10;
  expect_error(png, ErrorCode::kBadFormat, "claims 4100x4100 pixels, which its few bytes cannot hold");
  expect_error(text_bytes("P5\n9999 9999\n255\n"), ErrorCode::kBadFormat, "few bytes");
  // The highest compression of deflate and JPEG, for a uniform image, stays within the limit.
  EXPECT_TRUE(info_of(test::encode_png({0, 1, false}, 2048, 2048, Bytes(std::size_t{2048} * 2048 / 8))));
  EXPECT_TRUE(info_of(test::encode_png({0, 16, false}, 512, 512, Bytes(std::size_t{512} * 512 * 2))));
  EXPECT_TRUE(info_of(test::encode_jpeg_gray(2048, 2048, Bytes(std::size_t{2048} * 2048))));
  EXPECT_TRUE(info_of(test::encode_jpeg_rgb(2048, 2048, Bytes(std::size_t{2048} * 2048 * 3))));
}

TEST_F(ReadImageInfo, TellsAPngOfOneKindFromOthers) {
  test::write_file(path_, test::encode_png({2, 8, false}, 5, 3, Bytes(std::size_t{5} * 3 * 3)));
  EXPECT_TRUE(is_png(path_.c_str(), 3, 8));
  EXPECT_FALSE(is_png(path_.c_str(), 1, 8));
  EXPECT_FALSE(is_png(path_.c_str(), 3, 16));
  EXPECT_TRUE(is_drawn_picture(path_));
  test::write_file(path_, test::encode_jpeg_rgb(8, 8, Bytes(std::size_t{8} * 8 * 3)));
  EXPECT_FALSE(is_png(path_.c_str(), 3, 8));
  test::write_file(path_, text_bytes("notes"));
  EXPECT_FALSE(is_png(path_.c_str(), 3, 8));
  EXPECT_FALSE(is_png(folder_.file("none").c_str(), 3, 8));
}

}  // namespace
}  // namespace kinetrace::imaging

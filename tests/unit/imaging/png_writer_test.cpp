#include "kinetrace/imaging/png_writer.hpp"

#include <filesystem>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/imaging/image_reader.hpp"
#include "temp_folder.hpp"

namespace kinetrace::imaging {
namespace {

constexpr int kWidth = 9;
constexpr int kHeight = 4;
constexpr int kStride = 12;  // Rows are longer than the image: writers must not write the padding.

class PngWriter : public ::testing::Test {
 protected:
  kinetrace::test::TempFolder folder_;
  std::string path_ = folder_.file("out.png");
  Arena arena_{std::size_t{1} << 18};
  ImageReader reader_ =
      ImageReader::create({.max_width_px = 16, .max_height_px = 16, .max_file_bytes = 1 << 16}, arena_).value();
};

TEST_F(PngWriter, GrayRoundTrip) {
  std::vector<std::uint8_t> pixels(kStride * kHeight);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] = static_cast<std::uint8_t>(5 * i);
  }
  const GrayView image{pixels.data(), kWidth, kHeight, kStride};
  const MutableGrayView back = take_image<std::uint8_t>(arena_, kWidth, kHeight);
  for (const PngEffort effort : {PngEffort::kSmall, PngEffort::kFast, PngEffort::kFlat}) {
    ASSERT_TRUE(write_png_gray8(path_.c_str(), image, effort));
    ASSERT_TRUE(reader_.read_gray(path_.c_str(), back));
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        EXPECT_EQ(back.at(x, y), image.at(x, y));
      }
    }
  }
}

TEST_F(PngWriter, SixteenBitRoundTrip) {
  std::vector<std::uint16_t> pixels(kStride * kHeight);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] = static_cast<std::uint16_t>(1001 * i);
  }
  const ImageView<const std::uint16_t> image{pixels.data(), kWidth, kHeight, kStride};
  const ImageView<std::uint16_t> back = take_image<std::uint16_t>(arena_, kWidth, kHeight);
  for (const PngEffort effort : {PngEffort::kSmall, PngEffort::kFast, PngEffort::kFlat}) {
    ASSERT_TRUE(write_png_gray16(path_.c_str(), image, effort));
    ASSERT_TRUE(reader_.read_gray16(path_.c_str(), back));
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        EXPECT_EQ(back.at(x, y), image.at(x, y));
      }
    }
  }
}

TEST_F(PngWriter, ColourIsReadBackAsLuma) {
  const std::vector<Rgb8> pixels(kStride * kHeight, Rgb8{10, 200, 90});
  ASSERT_TRUE(write_png_rgb8(path_.c_str(), {pixels.data(), kWidth, kHeight, kStride}));
  const MutableGrayView back = take_image<std::uint8_t>(arena_, kWidth, kHeight);
  ASSERT_TRUE(reader_.read_gray(path_.c_str(), back));
  EXPECT_EQ(back.at(8, 3), (77 * 10 + 150 * 200 + 29 * 90 + 128) >> 8);
}

TEST_F(PngWriter, NamesTheFileItCannotCreate) {
  const std::uint8_t pixel = 0;
  const std::string nowhere = (folder_.path() / "no_such_folder" / "out.png").string();
  const Status status = write_png_gray8(nowhere.c_str(), {&pixel, 1, 1, 1});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kIo);
  EXPECT_THAT(status.error().message, ::testing::HasSubstr(nowhere));
}

TEST_F(PngWriter, RefusesAnEmptyImage) {
  const Status status = write_png_gray8(path_.c_str(), {});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kInvalidArgument);
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(PngWriter, ReportsAFullDeviceAndLeavesItWhereItIs) {
  if (!std::filesystem::exists("/dev/full")) {
    GTEST_SKIP() << "no /dev/full on this system";
  }
  const std::string link = folder_.file("full.png");
  std::filesystem::create_symlink("/dev/full", link);
  const std::vector<std::uint8_t> pixels(kStride * kHeight);
  const Status status = write_png_gray8(link.c_str(), {pixels.data(), kWidth, kHeight, kStride});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kIo);
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

}  // namespace
}  // namespace kinetrace::imaging

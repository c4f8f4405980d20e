#include "capture/luminance_reader.hpp"

#include <optional>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <turbojpeg.h>

namespace kinetrace::hal {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// A reader for a format and size, and the device's image properties.
class Bench {
 public:
  Bench(PixelFormat format, int width, int height, int stride_bytes) {
    CaptureConfig config;
    config.format = format;
    config.width_px = width;
    config.height_px = height;
    arena_ = Arena(LuminanceReader::required_bytes(config) + 1);
    reader_.emplace(LuminanceReader::create(config, arena_).value());
    info.name = "camera";
    info.format = format;
    info.width_px = width;
    info.height_px = height;
    info.stride_bytes = stride_bytes;
  }
  Result<GrayView> read(const Bytes& bytes) {
    CapturedImage image;
    image.data = std::as_bytes(std::span(bytes));
    return reader_->read(image, info);
  }
  [[nodiscard]] std::size_t used_bytes() const { return arena_.used_bytes(); }

  CaptureInfo info;

 private:
  Arena arena_;
  std::optional<LuminanceReader> reader_;
};

Bytes pixels_of(const GrayView& view) {
  Bytes pixels;
  for (int y = 0; y < view.height; ++y) {
    pixels.insert(pixels.end(), view.row(y), view.row(y) + view.width);
  }
  return pixels;
}

Bytes counting(std::size_t count) {
  Bytes bytes(count);
  for (std::size_t i = 0; i < count; ++i) {
    bytes[i] = static_cast<std::uint8_t>(i);
  }
  return bytes;
}

void expect_refused(Bench& bench, const Bytes& bytes) {
  const auto view = bench.read(bytes);
  ASSERT_FALSE(view);
  EXPECT_EQ(view.error().code, ErrorCode::kBadFormat);
  EXPECT_THAT(view.error().message, ::testing::StartsWith("camera: "));
}

TEST(LuminanceReader, ViewsGreyInPlaceWithItsPadding) {
  Bench bench(PixelFormat::kGrey8, 3, 2, 5);
  const Bytes bytes = counting(8);
  const auto view = bench.read(bytes);
  ASSERT_TRUE(view) << view.error().message;
  EXPECT_EQ(view->data, bytes.data());
  EXPECT_EQ(view->stride, 5);
  EXPECT_EQ(pixels_of(*view), (Bytes{0, 1, 2, 5, 6, 7}));
  EXPECT_EQ(bench.used_bytes(), 0U);
}

TEST(LuminanceReader, ViewsTheLuminanceOfNv12InPlace) {
  Bench bench(PixelFormat::kNv12, 4, 2, 4);
  const Bytes bytes = counting(4 * 2 + 4);
  const auto view = bench.read(bytes);
  ASSERT_TRUE(view) << view.error().message;
  EXPECT_EQ(view->data, bytes.data());
  EXPECT_EQ(pixels_of(*view), (Bytes{0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST(LuminanceReader, TakesEverySecondByteOfYuyv) {
  Bench bench(PixelFormat::kYuyv, 3, 2, 8);
  const auto view = bench.read(counting(14));
  ASSERT_TRUE(view) << view.error().message;
  EXPECT_EQ(pixels_of(*view), (Bytes{0, 2, 4, 8, 10, 12}));
}

TEST(LuminanceReader, TakesTheUpperBitsOfSamples) {
  const Bytes samples{0xff, 0x03, 0x04, 0x00, 0x03, 0x00};
  Bench ten(PixelFormat::kGrey10, 3, 1, 6);
  const auto of_ten = ten.read(samples);
  ASSERT_TRUE(of_ten) << of_ten.error().message;
  EXPECT_EQ(pixels_of(*of_ten), (Bytes{255, 1, 0}));
  Bench sixteen(PixelFormat::kGrey16, 3, 1, 6);
  const auto of_sixteen = sixteen.read({0xff, 0xff, 0xff, 0x01, 0xff, 0x00});
  ASSERT_TRUE(of_sixteen) << of_sixteen.error().message;
  EXPECT_EQ(pixels_of(*of_sixteen), (Bytes{255, 1, 0}));
}

TEST(LuminanceReader, TenBitSamplesBeyondTheirRangeAreWhite) {
  Bench bench(PixelFormat::kGrey10, 1, 1, 2);
  const auto view = bench.read({0x00, 0x04});
  ASSERT_TRUE(view) << view.error().message;
  EXPECT_EQ(view->at(0, 0), 255);
}

TEST(LuminanceReader, ReadsASinglePixelOfEveryFormat) {
  for (const PixelFormat format : {PixelFormat::kGrey8, PixelFormat::kNv12, PixelFormat::kYuyv, PixelFormat::kGrey16}) {
    SCOPED_TRACE(to_string(format));
    Bench bench(format, 1, 1, 2);
    const Bytes bytes{77, 77};
    const auto view = bench.read(bytes);
    ASSERT_TRUE(view) << view.error().message;
    EXPECT_EQ(view->width, 1);
    EXPECT_EQ(view->at(0, 0), 77);
  }
}

TEST(LuminanceReader, OneByteTooFewIsRefused) {
  struct Case {
    PixelFormat format;
    int stride_bytes;
    std::size_t needed;  // Of 3x2 pixels; the last row needs no padding.
  };
  for (const Case& one :
       {Case{PixelFormat::kGrey8, 5, 8}, Case{PixelFormat::kNv12, 5, 8}, Case{PixelFormat::kYuyv, 8, 14},
        Case{PixelFormat::kGrey10, 6, 12}, Case{PixelFormat::kGrey16, 7, 13}}) {
    SCOPED_TRACE(to_string(one.format));
    Bench bench(one.format, 3, 2, one.stride_bytes);
    EXPECT_TRUE(bench.read(counting(one.needed)));
    expect_refused(bench, counting(one.needed - 1));
    expect_refused(bench, {});
  }
}

TEST(LuminanceReader, ADeviceThatDeliversSomethingElseIsRefused) {
  const auto refuses = [](auto change) {
    Bench bench(PixelFormat::kYuyv, 4, 2, 8);
    change(bench.info);
    expect_refused(bench, counting(1000));
  };
  refuses([](CaptureInfo& info) { info.format = PixelFormat::kGrey8; });
  refuses([](CaptureInfo& info) { info.width_px = 6; });
  refuses([](CaptureInfo& info) { info.height_px = 3; });
  refuses([](CaptureInfo& info) { info.stride_bytes = 7; });
  refuses([](CaptureInfo& info) { info.stride_bytes = -8; });
  Bench in_place(PixelFormat::kGrey8, 4, 2, 4);
  in_place.info.height_px = 0;
  expect_refused(in_place, counting(1000));
}

TEST(LuminanceReader, AnArenaThatIsTooSmallIsAnError) {
  CaptureConfig config;
  config.format = PixelFormat::kYuyv;
  Arena arena(LuminanceReader::required_bytes(config) - 1);
  const auto reader = LuminanceReader::create(config, arena);
  ASSERT_FALSE(reader);
  EXPECT_EQ(reader.error().code, ErrorCode::kCapacity);
}

class MjpegReading : public ::testing::Test {
 protected:
  static constexpr int kWidth = 24;
  static constexpr int kHeight = 16;
  static Bytes encode(int width, int height) {
    const Bytes pixels(static_cast<std::size_t>(width * height), 140);
    const tjhandle encoder = tjInitCompress();
    unsigned char* bytes = nullptr;
    unsigned long size = 0;
    tjCompress2(encoder, pixels.data(), width, width, height, TJPF_GRAY, &bytes, &size, TJSAMP_GRAY, 95, 0);
    Bytes jpeg(bytes, bytes + size);
    tjFree(bytes);
    tjDestroy(encoder);
    return jpeg;
  }
  Bench bench_{PixelFormat::kMjpeg, kWidth, kHeight, 0};
};

TEST_F(MjpegReading, DecodesToGray) {
  const auto view = bench_.read(encode(kWidth, kHeight));
  ASSERT_TRUE(view) << view.error().message;
  EXPECT_EQ(view->width, kWidth);
  for (const int pixel : pixels_of(*view)) {
    EXPECT_NEAR(pixel, 140, 1);
  }
}

TEST_F(MjpegReading, WhatIsCutOrOfAnotherSizeIsDamaged) {
  Bytes cut = encode(kWidth, kHeight);
  cut.resize(cut.size() / 2);
  expect_refused(bench_, cut);
  expect_refused(bench_, {});
  expect_refused(bench_, counting(100));
  expect_refused(bench_, encode(kWidth, kHeight + 8));
}

TEST_F(MjpegReading, AfterDamageComesTheNextImage) {
  EXPECT_FALSE(bench_.read(counting(100)));
  EXPECT_TRUE(bench_.read(encode(kWidth, kHeight)));
}

}  // namespace
}  // namespace kinetrace::hal

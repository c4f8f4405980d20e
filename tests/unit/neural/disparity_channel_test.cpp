#include "disparity_channel.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::neural {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 32;
constexpr std::size_t kPixels = std::size_t{kWidth} * kHeight;

/// Answers with given disparities, and keeps the images.
class KnownDisparities final : public Runtime {
 public:
  Result<std::span<const Tensor>> run(std::span<const float> /*input*/) override { return std::span<const Tensor>(); }
  Status match(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right, int width_px,
               std::span<std::int16_t> disparity) override {
    left_.assign(left.begin(), left.end());
    right_.assign(right.begin(), right.end());
    width_px_ = width_px;
    std::fill(disparity.begin(), disparity.end(), std::int16_t{-kDisparityFraction});
    disparity[0] = 2 * kDisparityFraction;
    disparity[1] = kMaxDisparity;
    return {};
  }

  std::vector<std::uint8_t> left_;
  std::vector<std::uint8_t> right_;
  int width_px_ = 0;
};

std::vector<float> filled(View view, KnownDisparities& runtime) {
  ModelInput input;
  input.width_px = kWidth;
  input.height_px = kHeight;
  Arena arena(1 << 20);
  DisparityChannel channel(input, arena);
  std::vector<float> picture(kPixels, 100.F);
  picture[0] = 20.F;  // a mean of 80 with its three neighbours
  const std::vector<float> other(kPixels, 50.F);
  std::vector<float> result(kPixels, -1.F);
  EXPECT_TRUE(channel.fill(picture, other, view, runtime, result));
  return result;
}

TEST(DisparityChannel, HoldsLogarithmsOfDisparitiesInPixelsOfTheInput) {
  KnownDisparities runtime;
  const std::vector<float> channel = filled(View::kLeft, runtime);
  for (const std::size_t pixel : {0, 1, kWidth, kWidth + 1}) {
    EXPECT_FLOAT_EQ(channel[pixel], std::log2(1.F + 4.F) / 7.F);
    EXPECT_FLOAT_EQ(channel[pixel + 2], std::log2(1.F + 128.F) / 7.F);
    EXPECT_EQ(channel[pixel + 4], 0.F) << "unknown";
  }
  EXPECT_EQ(std::count(channel.begin(), channel.end(), 0.F), kPixels - 8);
}

TEST(DisparityChannel, MatchesMeansOfPixels) {
  KnownDisparities runtime;
  filled(View::kLeft, runtime);
  EXPECT_EQ(runtime.width_px_, kWidth / 2);
  ASSERT_EQ(runtime.left_.size(), kPixels / 4);
  EXPECT_EQ(runtime.left_[0], 80);
  EXPECT_EQ(runtime.left_[1], 100);
  EXPECT_EQ(runtime.right_[0], 50);
}

TEST(DisparityChannel, ARightPictureIsMirrored) {
  KnownDisparities runtime;
  const std::vector<float> channel = filled(View::kRight, runtime);
  EXPECT_EQ(runtime.left_[kWidth / 2 - 1], 80);
  EXPECT_FLOAT_EQ(channel[kWidth - 1], std::log2(1.F + 4.F) / 7.F);
  EXPECT_FLOAT_EQ(channel[kWidth - 3], std::log2(1.F + 128.F) / 7.F);
  EXPECT_EQ(channel[0], 0.F);
}

}  // namespace
}  // namespace kinetrace::neural

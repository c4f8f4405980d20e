#include "letterbox.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::neural {
namespace {

ModelInput input(int width, int height, InputColours colours = InputColours::kGray) {
  ModelInput made;
  made.width_px = width;
  made.height_px = height;
  made.colours = colours;
  made.scale = 1.F;
  return made;
}

std::vector<float> filled(const Picture& picture, const ModelInput& size) {
  Arena arena(1 << 24);
  Letterbox letterbox(size, picture.width_px, picture.height_px, arena);
  std::vector<float> tensor(static_cast<std::size_t>(size.channels() * size.width_px * size.height_px));
  letterbox.fill(picture, Placement::of(picture.width_px, picture.height_px, size), tensor);
  return tensor;
}

TEST(Placement, KeepsTheAspectAndCentres) {
  const Placement placement = Placement::of(1242, 375, input(640, 192));
  EXPECT_EQ(placement.height, 192);
  EXPECT_EQ(placement.width, 636);
  EXPECT_EQ(placement.x0, 2);
  EXPECT_EQ(placement.y0, 0);
  EXPECT_NEAR(placement.input_x(621.0), 320.0, 1e-9);
  EXPECT_NEAR(placement.picture_x(placement.input_x(123.0)), 123.0, 1e-9);
  EXPECT_NEAR(placement.picture_y(placement.input_y(45.0)), 45.0, 1e-9);
}

TEST(Placement, StretchesWhereThatIsWanted) {
  ModelInput size = input(64, 64);
  size.fit = InputFit::kStretch;
  const Placement placement = Placement::of(128, 32, size);
  EXPECT_EQ(placement.width, 64);
  EXPECT_EQ(placement.height, 64);
  EXPECT_DOUBLE_EQ(placement.scale_x, 0.5);
  EXPECT_DOUBLE_EQ(placement.scale_y, 2.0);
}

TEST(Placement, OfAThinPictureIsNeverEmpty) {
  const Placement placement = Placement::of(5000, 1, input(64, 64));
  EXPECT_EQ(placement.height, 1);
}

TEST(Letterbox, OfTheSameSizeChangesNothing) {
  std::vector<std::uint8_t> pixels(std::size_t{32} * 32);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] = static_cast<std::uint8_t>(i * 7);
  }
  const std::vector<float> tensor = filled({pixels.data(), 32, 32, 32, 1}, input(32, 32));
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    EXPECT_NEAR(tensor[i], pixels[i], 1e-3);
  }
}

TEST(Letterbox, ShrinkingAveragesAndKeepsTheMean) {
  // Stripes of one pixel: picking samples instead of averaging would give all black or all white.
  std::vector<std::uint8_t> pixels(std::size_t{128} * 128);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] = i % 2 == 0 ? 0 : 200;
  }
  const std::vector<float> tensor = filled({pixels.data(), 128, 128, 128, 1}, input(32, 32));
  for (std::size_t y = 1; y < 31; ++y) {
    for (std::size_t x = 1; x < 31; ++x) {
      EXPECT_NEAR(tensor[y * 32 + x], 100.F, 3.F);
    }
  }
}

TEST(Letterbox, ARampStaysARampWhicheverWayItIsScaled) {
  for (const int width : {40, 64, 200}) {
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width) * 64);
    for (int i = 0; i < width * 64; ++i) {
      pixels[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(i % width);
    }
    ModelInput size = input(64, 64);
    size.fit = InputFit::kStretch;
    const std::vector<float> tensor = filled({pixels.data(), width, 64, width, 1}, size);
    const double step = width / 64.0;
    for (int x = 4; x < 60; ++x) {
      EXPECT_NEAR(tensor[static_cast<std::size_t>(32 * 64 + x)], (x + 0.5) * step - 0.5, 0.05) << width;
    }
  }
}

TEST(Letterbox, TheBorderIsPadAndIsScaledToo) {
  const std::vector<std::uint8_t> pixels(std::size_t{64} * 32, 10);
  ModelInput size = input(64, 64);
  size.scale = 0.5F;
  size.mean = {4.F, 0.F, 0.F};
  size.deviation = {2.F, 1.F, 1.F};
  const std::vector<float> tensor = filled({pixels.data(), 64, 32, 64, 1}, size);
  EXPECT_FLOAT_EQ(tensor[0], (114 * 0.5F - 4.F) / 2.F);
  EXPECT_FLOAT_EQ(tensor[32 * 64 + 32], (10 * 0.5F - 4.F) / 2.F);
  EXPECT_FLOAT_EQ(tensor.back(), tensor[0]);
}

TEST(Letterbox, ColoursComeInTheOrderThatIsWanted) {
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < 32 * 32; ++i) {
    pixels.insert(pixels.end(), {10, 20, 30});
  }
  const Picture picture{pixels.data(), 32, 32, 96, 3};
  const std::vector<float> rgb = filled(picture, input(32, 32, InputColours::kRgb));
  const std::vector<float> bgr = filled(picture, input(32, 32, InputColours::kBgr));
  const std::vector<float> gray = filled(picture, input(32, 32));
  EXPECT_NEAR(rgb[0], 10.F, 1e-3);
  EXPECT_NEAR(rgb[std::size_t{2} * 32 * 32], 30.F, 1e-3);
  EXPECT_NEAR(bgr[0], 30.F, 1e-3);
  EXPECT_NEAR(bgr[std::size_t{2} * 32 * 32], 10.F, 1e-3);
  EXPECT_NEAR(gray[0], 0.299F * 10 + 0.587F * 20 + 0.114F * 30, 1e-2);
}

TEST(Letterbox, AGreyPictureGivesAColourNetworkThreeEqualChannels) {
  const std::vector<std::uint8_t> pixels(std::size_t{32} * 32, 77);
  ModelInput size = input(32, 32, InputColours::kRgb);
  size.mean = {7.F, 0.F, 0.F};
  const std::vector<float> tensor = filled({pixels.data(), 32, 32, 32, 1}, size);
  EXPECT_NEAR(tensor[0], 70.F, 1e-3);
  EXPECT_NEAR(tensor[std::size_t{32} * 32], 77.F, 1e-3);
  EXPECT_NEAR(tensor[std::size_t{2} * 32 * 32], 77.F, 1e-3);
}

TEST(Letterbox, ASmallerPictureThanPlannedIsFine) {
  Arena arena(1 << 24);
  const ModelInput size = input(64, 64);
  Letterbox letterbox(size, 500, 500, arena);
  std::vector<float> tensor(std::size_t{64} * 64);
  for (const int side : {500, 3, 64, 1, 127}) {
    const std::vector<std::uint8_t> pixels(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), 50);
    letterbox.fill({pixels.data(), side, side, side, 1}, Placement::of(side, side, size), tensor);
    EXPECT_NEAR(*std::min_element(tensor.begin(), tensor.end()), 50.F, 1e-3) << side;
    EXPECT_NEAR(*std::max_element(tensor.begin(), tensor.end()), 50.F, 1e-3) << side;
  }
}

}  // namespace
}  // namespace kinetrace::neural

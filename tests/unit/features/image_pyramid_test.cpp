#include "image_pyramid.hpp"

#include <vector>

#include <gtest/gtest.h>

#include "synthetic_scene.hpp"

namespace kinetrace::features {
namespace {

using testing::Image;

class PyramidOf {
 public:
  PyramidOf(const Image& image, int levels) {
    const int width = image.view().width;
    const int height = image.view().height;
    std::vector<std::uint16_t> scratch(static_cast<std::size_t>(width) + 32);
    arena_ = Arena(measure_bytes([&](Arena& arena) { ImagePyramid(arena, width, height, levels); }));
    pyramid_ = ImagePyramid(arena_, width, height, levels);
    pyramid_.build(image.view(), scratch);
  }
  [[nodiscard]] const ImagePyramid& operator*() const { return pyramid_; }
  [[nodiscard]] int at(int level, int x, int y) const {
    const Plane plane = pyramid_.level(level);
    return plane.data[y * plane.stride + x];
  }

 private:
  Arena arena_;
  ImagePyramid pyramid_;
};

TEST(ImagePyramid, HalvesUntilTheSmallestSideWouldFallBelowSixteen) {
  EXPECT_EQ(ImagePyramid::supported_levels(1242, 375, 4), 4);
  EXPECT_EQ(ImagePyramid::supported_levels(1242, 375, 6), 5);
  EXPECT_EQ(ImagePyramid::supported_levels(64, 48, 4), 2);
  EXPECT_EQ(ImagePyramid::supported_levels(16, 16, 4), 1);
}

TEST(ImagePyramid, KeepsAConstantImage) {
  const PyramidOf pyramid(Image(101, 67, 173), 3);
  for (int level = 0; level < 3; ++level) {
    const Plane plane = (*pyramid).level(level);
    EXPECT_EQ(plane.width, 101 >> level);
    EXPECT_EQ(plane.height, 67 >> level);
    for (int y = -kPadding; y < plane.height + kPadding; ++y) {
      for (int x = -kPadding; x < plane.width + kPadding; ++x) {
        ASSERT_EQ(pyramid.at(level, x, y), 173) << level << ' ' << x << ' ' << y;
      }
    }
  }
}

TEST(ImagePyramid, CentresPixelsWhereToLevelSaysSo) {
  const Image ramp = testing::render(128, 96, [](const Eigen::Vector2d& p) { return p.x() + p.y(); });
  const PyramidOf pyramid(ramp, 3);
  for (int level = 1; level < 3; ++level) {
    const Plane plane = (*pyramid).level(level);
    for (int y = 2; y < plane.height - 2; ++y) {
      for (int x = 2; x < plane.width - 2; ++x) {
        const float expected = from_level(static_cast<float>(x), level) + from_level(static_cast<float>(y), level);
        ASSERT_NEAR(static_cast<float>(pyramid.at(level, x, y)), expected, 1.F);
      }
    }
  }
}

TEST(ImagePyramid, RepeatsTheBorderInThePadding) {
  const Image ramp = testing::render(64, 48, [](const Eigen::Vector2d& p) { return 2.0 * p.x() + p.y(); });
  const PyramidOf pyramid(ramp, 1);
  EXPECT_EQ(pyramid.at(0, -kPadding, 10), pyramid.at(0, 0, 10));
  EXPECT_EQ(pyramid.at(0, 63 + kPadding, 10), pyramid.at(0, 63, 10));
  EXPECT_EQ(pyramid.at(0, 20, -kPadding), pyramid.at(0, 20, 0));
  EXPECT_EQ(pyramid.at(0, 20, 47 + kPadding), pyramid.at(0, 20, 47));
  EXPECT_EQ(pyramid.at(0, 63 + kPadding, 47 + kPadding), pyramid.at(0, 63, 47));
}

}  // namespace
}  // namespace kinetrace::features

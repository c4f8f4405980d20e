#include "output/mask_degradation.hpp"

#include <map>
#include <set>

#include <gtest/gtest.h>

namespace kinetrace::simulator {
namespace {

constexpr std::uint16_t kCar = 1004;
constexpr std::uint16_t kWalker = 2007;

void fill(Image<std::uint16_t>& image, int x0, int y0, int x1, int y1, std::uint16_t label) {
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      image.at(x, y) = label;
    }
  }
}

Image<std::uint16_t> two_objects() {
  Image<std::uint16_t> labels(300, 120);
  fill(labels, 40, 30, 120, 90, kCar);
  fill(labels, 200, 20, 225, 95, kWalker);
  return labels;
}

std::map<std::uint16_t, int> count(const Image<std::uint16_t>& labels) {
  std::map<std::uint16_t, int> result;
  for (const std::uint16_t label : labels.pixels()) {
    ++result[label];
  }
  result.erase(0);
  return result;
}

constexpr DegradationSettings kSure{.miss_probability = 0.0, .false_probability = 0.0};

TEST(MaskDegradation, KeepsClassesAndMostPixels) {
  const Image<std::uint16_t> exact = two_objects();
  for (std::uint32_t stream = 0; stream < 20; ++stream) {
    const Image<std::uint16_t> degraded = degraded_masks(exact, kSure, stream);
    std::map<int, int> both;
    std::map<int, int> either;
    for (std::size_t i = 0; i < exact.pixels().size(); ++i) {
      for (const int class_id : {1, 2}) {
        const bool a = exact.pixels()[i] / 1000 == class_id;
        const bool b = degraded.pixels()[i] / 1000 == class_id;
        both[class_id] += a && b ? 1 : 0;
        either[class_id] += a || b ? 1 : 0;
      }
    }
    EXPECT_GT(static_cast<double>(both[1]) / either[1], 0.88);
    EXPECT_GT(static_cast<double>(both[2]) / either[2], 0.75);
    EXPECT_LT(static_cast<double>(both[1]) / either[1], 1.0);
    for (const auto& [label, area] : count(degraded)) {
      EXPECT_LE(label % 1000, 2);
    }
  }
}

TEST(MaskDegradation, DriftsNoFurtherThanAFewPixels) {
  const Image<std::uint16_t> degraded = degraded_masks(two_objects(), kSure, 3);
  for (int y = 0; y < degraded.height(); ++y) {
    for (int x = 0; x < degraded.width(); ++x) {
      const bool well_inside = x >= 46 && x < 114 && y >= 36 && y < 84;
      const bool well_outside = (x < 34 || x >= 126) && (x < 194 || x >= 231);
      if (well_inside) {
        EXPECT_EQ(degraded.at(x, y) / 1000, 1);
      }
      if (well_outside) {
        EXPECT_EQ(degraded.at(x, y), 0);
      }
    }
  }
}

TEST(MaskDegradation, MissesAsOftenAsIsSet) {
  DegradationSettings settings = kSure;
  settings.miss_probability = 0.05;
  int found = 0;
  constexpr int kPictures = 600;
  Image<std::uint16_t> labels(60, 40);
  fill(labels, 5, 5, 20, 30, kCar);
  fill(labels, 30, 5, 50, 30, kWalker);
  for (std::uint32_t stream = 0; stream < kPictures; ++stream) {
    found += static_cast<int>(count(degraded_masks(labels, settings, stream)).size());
  }
  // Six standard deviations of a binomial count.
  EXPECT_NEAR(found, 2 * kPictures * 0.95, 6.0 * std::sqrt(2 * kPictures * 0.95 * 0.05));
}

TEST(MaskDegradation, InventsObjectsWhereThereAreNone) {
  DegradationSettings settings = kSure;
  settings.false_probability = 1.0;
  const Image<std::uint16_t> nothing(200, 100);
  const auto found = count(degraded_masks(nothing, settings, 1));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found.begin()->first, 1001);
  EXPECT_TRUE(count(degraded_masks(nothing, kSure, 1)).empty());
}

TEST(MaskDegradation, NeverFindsTheSmallest) {
  Image<std::uint16_t> labels(60, 40);
  fill(labels, 10, 10, 15, 15, kCar);
  EXPECT_TRUE(count(degraded_masks(labels, kSure, 1)).empty());
}

TEST(MaskDegradation, ShufflesIdsFromPictureToPicture) {
  Image<std::uint16_t> labels(120, 20);
  for (int i = 0; i < 6; ++i) {
    fill(labels, 20 * i + 2, 2, 20 * i + 18, 18, static_cast<std::uint16_t>(1001 + i));
  }
  std::set<std::uint16_t> ids_of_first;
  for (std::uint32_t stream = 0; stream < 30; ++stream) {
    const Image<std::uint16_t> shuffled = shuffled_masks(labels, stream);
    const auto found = count(shuffled);
    EXPECT_EQ(found.size(), 6U);
    EXPECT_EQ(found.begin()->first, 1001);
    EXPECT_EQ(found.rbegin()->first, 1006);
    ids_of_first.insert(shuffled.at(10, 10));
  }
  EXPECT_GE(ids_of_first.size(), 4U);
}

TEST(MaskDegradation, DependsOnItsStreamAlone) {
  const Image<std::uint16_t> labels = two_objects();
  EXPECT_EQ(degraded_masks(labels, {}, 5).pixels(), degraded_masks(labels, {}, 5).pixels());
  EXPECT_NE(degraded_masks(labels, kSure, 5).pixels(), degraded_masks(labels, kSure, 6).pixels());
}

}  // namespace
}  // namespace kinetrace::simulator

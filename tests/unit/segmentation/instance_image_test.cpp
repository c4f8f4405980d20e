#include "kinetrace/segmentation/instance_image.hpp"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::segmentation {
namespace {

constexpr int kWidth = 61;  // not a multiple of the run scan's step
constexpr int kHeight = 40;
constexpr std::size_t kPixels = std::size_t{kWidth} * kHeight;

std::size_t index_of(int x, int y) {
  return static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x);
}

class InstanceRelabelerTest : public ::testing::Test {
 protected:
  InstanceRelabelerTest() : relabeler_(arena_), detections_(arena_, kMaxObjects) {}

  void fill(int x0, int y0, int width, int height, std::uint16_t value) {
    for (int y = y0; y < y0 + height; ++y) {
      for (int x = x0; x < x0 + width; ++x) {
        values_[index_of(x, y)] = value;
      }
    }
  }
  int relabel(MaskEncoding encoding = MaskEncoding::kMots, int max_objects = 16, int min_area_px = 1) {
    return relabeler_.relabel({values_.data(), kWidth, kHeight, kWidth}, encoding, max_objects, min_area_px,
                              {labels_.data(), kWidth, kHeight, kWidth}, detections_);
  }
  [[nodiscard]] std::uint8_t label(int x, int y) const { return labels_[index_of(x, y)]; }

  Arena arena_{1U << 20U};
  InstanceRelabeler relabeler_;
  FixedVector<Detection> detections_;
  std::vector<std::uint16_t> values_ = std::vector<std::uint16_t>(kPixels);
  std::vector<std::uint8_t> labels_ = std::vector<std::uint8_t>(kPixels, 99);
};

TEST_F(InstanceRelabelerTest, FindsNothingInAnEmptyMask) {
  EXPECT_EQ(relabel(), 0);
  EXPECT_TRUE(detections_.empty());
  EXPECT_TRUE(std::all_of(labels_.begin(), labels_.end(), [](std::uint8_t l) { return l == kBackgroundLabel; }));
}

TEST_F(InstanceRelabelerTest, NumbersByAreaAndReadsTheClass) {
  fill(0, 0, 5, 5, 2007);
  fill(50, 20, 11, 10, 1042);
  EXPECT_EQ(relabel(), 0);
  ASSERT_EQ(detections_.size(), 2U);
  EXPECT_EQ(detections_[0].label, 1);
  EXPECT_EQ(detections_[0].class_id, kVehicleClass);
  EXPECT_EQ(detections_[0].area_px, 110);
  EXPECT_EQ(detections_[0].box_px.x0, 50);
  EXPECT_EQ(detections_[0].box_px.y0, 20);
  EXPECT_EQ(detections_[0].box_px.x1, 61);
  EXPECT_EQ(detections_[0].box_px.y1, 30);
  EXPECT_EQ(detections_[1].class_id, kPedestrianClass);
  EXPECT_EQ(label(60, 29), 1);
  EXPECT_EQ(label(4, 4), 2);
  EXPECT_EQ(label(5, 4), kBackgroundLabel);
}

TEST_F(InstanceRelabelerTest, CountsAllPartsOfAnInstance) {
  fill(0, 0, 4, 4, 1001);
  fill(40, 30, 4, 4, 1001);
  relabel();
  ASSERT_EQ(detections_.size(), 1U);
  EXPECT_EQ(detections_[0].area_px, 32);
  EXPECT_EQ(detections_[0].box_px.width(), 44);
}

TEST_F(InstanceRelabelerTest, MarksIgnoredPixels) {
  fill(3, 3, 10, 10, 10000);
  EXPECT_EQ(relabel(), 0);
  EXPECT_TRUE(detections_.empty());
  EXPECT_EQ(label(12, 12), kIgnoreLabel);
  EXPECT_EQ(label(13, 12), kBackgroundLabel);
}

TEST_F(InstanceRelabelerTest, TreatsEightBitValuesAsInstancesOfUnknownClass) {
  fill(0, 0, 5, 5, 200);
  fill(10, 0, 5, 5, 255);
  relabel(MaskEncoding::kInstance);
  ASSERT_EQ(detections_.size(), 1U);
  EXPECT_EQ(detections_[0].class_id, kUnknownClass);
  EXPECT_EQ(label(11, 1), kIgnoreLabel);
}

TEST_F(InstanceRelabelerTest, KeepsTheLargestAtCapacityAndIgnoresTheRest) {
  for (int k = 0; k < 5; ++k) {
    fill(10 * k, 0, 3 + k, 4, static_cast<std::uint16_t>(1001 + k));
  }
  EXPECT_EQ(relabel(MaskEncoding::kMots, 5), 0);
  EXPECT_EQ(detections_.size(), 5U);
  EXPECT_EQ(relabel(MaskEncoding::kMots, 4), 1);
  ASSERT_EQ(detections_.size(), 4U);
  EXPECT_EQ(label(0, 0), kIgnoreLabel);
  EXPECT_EQ(label(40, 0), 1);
}

TEST_F(InstanceRelabelerTest, HoldsNoneSixtyFourAndNotTheSixtyFifth) {
  for (int count : {0, kMaxObjects, kMaxObjects + 1}) {
    std::fill(values_.begin(), values_.end(), std::uint16_t{0});
    for (int k = 0; k < count; ++k) {
      // The last one is the smallest.
      fill(6 * (k % 10), 5 * (k / 10), k < kMaxObjects ? 4 : 3, 4, static_cast<std::uint16_t>(1001 + k));
    }
    const int held = std::min(count, kMaxObjects);
    EXPECT_EQ(relabel(MaskEncoding::kMots, kMaxObjects), count - held) << count;
    EXPECT_EQ(detections_.size(), static_cast<std::size_t>(held)) << count;
  }
  EXPECT_EQ(label(0, 0), 1);
  EXPECT_EQ(label(6 * (kMaxObjects % 10), 5 * (kMaxObjects / 10)), kIgnoreLabel) << "seen, but nobody's";
}

TEST_F(InstanceRelabelerTest, DropsInstancesBelowTheSmallestArea) {
  fill(0, 0, 3, 3, 1001);
  fill(10, 0, 2, 5, 1002);
  EXPECT_EQ(relabel(MaskEncoding::kMots, 16, 10), 1);
  ASSERT_EQ(detections_.size(), 1U);
  EXPECT_EQ(detections_[0].area_px, 10);
  EXPECT_EQ(label(0, 0), kBackgroundLabel);
}

TEST_F(InstanceRelabelerTest, SurvivesMoreValuesThanItHoldsAndForgetsThem) {
  for (std::size_t i = 0; i < values_.size(); ++i) {
    values_[i] = static_cast<std::uint16_t>(i + 1);
  }
  const int values = kWidth * kHeight;
  EXPECT_EQ(relabel(MaskEncoding::kMots, 16, 1), values - 16);
  EXPECT_EQ(label(kWidth - 1, kHeight - 1), kIgnoreLabel);
  std::fill(values_.begin(), values_.end(), std::uint16_t{0});
  EXPECT_EQ(relabel(), 0);
  EXPECT_EQ(label(kWidth - 1, kHeight - 1), kBackgroundLabel);
}

}  // namespace
}  // namespace kinetrace::segmentation

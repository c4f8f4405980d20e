#include "kinetrace/segmentation/mask_fusion.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::segmentation {
namespace {

constexpr int kWidth = 97;  // Not a multiple of the kernel's step.
constexpr int kHeight = 40;
constexpr StereoGeometry kGeometry{.fx_px = 100.0,
                                   .fy_px = 100.0,
                                   .cx_px = 48.0,
                                   .cy_px = 20.0,
                                   .baseline_m = 0.5,
                                   .width_px = kWidth,
                                   .height_px = kHeight};
/// Of all instances: at this depth a person is at most 22 pixels tall.
constexpr float kDisparity_px = 5.F;
constexpr float kSure = 0.95F;
constexpr float kWeak = 0.3F;

/// Boxes of labels 1, 2, ... in an image.
class Drawing {
 public:
  void add(const PixelBox& box, std::uint16_t class_id = kUnknownClass, float score = 1.F) {
    instances_.push_back(
        {static_cast<std::uint8_t>(instances_.size() + 1), class_id, score, box, box.width() * box.height()});
    disparities_px_.push_back(kDisparity_px);
    fill(box, instances_.back().label);
  }
  void add_moving(const PixelBox& box) {
    add(box);
    instances_.back().moving = true;
  }
  void ignore(const PixelBox& box) { fill(box, kIgnoreLabel); }
  [[nodiscard]] LabelledInstances view() const {
    return {{pixels_.data(), kWidth, kHeight, kWidth}, instances_, disparities_px_};
  }

 private:
  void fill(const PixelBox& box, std::uint8_t label) {
    for (int y = box.y0; y < box.y1; ++y) {
      std::fill_n(pixels_.begin() + y * kWidth + box.x0, box.width(), label);
    }
  }
  std::vector<std::uint8_t> pixels_ = std::vector<std::uint8_t>(static_cast<std::size_t>(kWidth) * kHeight);
  std::vector<Detection> instances_;
  std::vector<float> disparities_px_;
};

class MaskFusionTest : public ::testing::Test {
 protected:
  void make(int max_objects = kMaxObjects, int min_area_px = 1) {
    const auto carve = [&](Arena& arena) { fusion_ = MaskFusion(kGeometry, max_objects, min_area_px, arena); };
    arena_ = std::make_unique<Arena>(measure_bytes(carve));
    carve(*arena_);
  }
  int fuse() { return fusion_.fuse(network_.view(), motion_.view()); }
  [[nodiscard]] std::span<const Detection> found() const { return fusion_.detections(); }
  [[nodiscard]] std::uint8_t at(int x, int y) const { return fusion_.labels().at(x, y); }
  /// Detections agree with the labels.
  void expect_consistent() const {
    std::vector<Detection> counted(found().size());
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const std::uint8_t label = at(x, y);
        if (label != kBackgroundLabel && label != kIgnoreLabel) {
          ASSERT_LE(label, counted.size());
          ++counted[label - 1U].area_px;
          counted[label - 1U].box_px.include(x, y);
        }
      }
    }
    for (std::size_t i = 0; i < counted.size(); ++i) {
      EXPECT_EQ(found()[i].label, i + 1);
      EXPECT_EQ(found()[i].area_px, counted[i].area_px) << i;
      EXPECT_EQ(found()[i].box_px.x0, counted[i].box_px.x0) << i;
      EXPECT_EQ(found()[i].box_px.y0, counted[i].box_px.y0) << i;
      EXPECT_EQ(found()[i].box_px.x1, counted[i].box_px.x1) << i;
      EXPECT_EQ(found()[i].box_px.y1, counted[i].box_px.y1) << i;
    }
  }

  std::unique_ptr<Arena> arena_;
  MaskFusion fusion_;
  Drawing network_;
  Drawing motion_;
};

TEST_F(MaskFusionTest, NothingOfNothing) {
  make();
  EXPECT_EQ(fuse(), 0);
  EXPECT_TRUE(found().empty());
  EXPECT_EQ(fusion_.fuse({}, {}), 0) << "nobody has looked";
  EXPECT_TRUE(found().empty());
}

TEST_F(MaskFusionTest, WhatStandsIsFoundByTheNetwork) {
  network_.add({10, 10, 30, 20}, kVehicleClass, kSure);
  make();
  fuse();
  ASSERT_EQ(found().size(), 1U);
  EXPECT_EQ(found()[0].class_id, kVehicleClass);
  EXPECT_GT(found()[0].score, 0.5F);
  expect_consistent();
}

TEST_F(MaskFusionTest, WhatMovesIsFoundWithoutTheNetwork) {
  motion_.add({10, 10, 30, 20});
  make();
  EXPECT_EQ(fusion_.fuse({}, motion_.view()), 0);
  ASSERT_EQ(found().size(), 1U);
  EXPECT_EQ(found()[0].class_id, kUnknownClass);
  expect_consistent();
}

TEST_F(MaskFusionTest, ACandidateOfALowScoreIsNoObject) {
  network_.add({10, 10, 30, 20}, kVehicleClass, kWeak);
  make();
  EXPECT_EQ(fuse(), 0);
  EXPECT_TRUE(found().empty());
  EXPECT_EQ(at(15, 15), kBackgroundLabel);
}

TEST_F(MaskFusionTest, ACandidateOfALowScoreIsAnObjectWhereItMoves) {
  network_.add({10, 10, 30, 20}, kPedestrianClass, kWeak);
  motion_.add({8, 8, 32, 20});
  make();
  fuse();
  ASSERT_EQ(found().size(), 1U);
  EXPECT_EQ(found()[0].class_id, kPedestrianClass);
  EXPECT_EQ(found()[0].area_px, 200) << "with the network's contour";
  EXPECT_EQ(at(8, 8), kBackgroundLabel);
  expect_consistent();
}

TEST_F(MaskFusionTest, ARegionElsewhereDoesNotHelpACandidate) {
  network_.add({10, 10, 30, 20}, kVehicleClass, kWeak);
  motion_.add({50, 10, 70, 20});
  make();
  fuse();
  ASSERT_EQ(found().size(), 1U);
  EXPECT_EQ(found()[0].class_id, kUnknownClass);
  EXPECT_EQ(at(15, 15), kBackgroundLabel);
  EXPECT_EQ(at(55, 15), 1);
}

TEST_F(MaskFusionTest, ACandidateTooImprobableIsNoneEvenWhereItMoves) {
  network_.add({10, 10, 30, 20}, kVehicleClass, 0.5F * kMinCandidateProbability);
  motion_.add({10, 10, 30, 20});
  make();
  fuse();
  ASSERT_EQ(found().size(), 1U);
  EXPECT_EQ(found()[0].class_id, kUnknownClass) << "it moves; what it is, nobody knows";
  EXPECT_EQ(found()[0].area_px, 200);
}

TEST_F(MaskFusionTest, ACandidateOnABitOfARegionGetsNoHelpFromIt) {
  network_.add({10, 10, 14, 14}, kPedestrianClass, kWeak);
  motion_.add({0, 0, 90, 40});
  make();
  fuse();
  ASSERT_EQ(found().size(), 1U);
  EXPECT_EQ(found()[0].class_id, kUnknownClass);
  EXPECT_EQ(found()[0].area_px, 90 * 40);
}

TEST_F(MaskFusionTest, ARegionOnTwoObjectsIsDividedByTheNetwork) {
  network_.add({10, 10, 30, 20}, kVehicleClass, kSure);
  network_.add({30, 10, 40, 20}, kPedestrianClass, kSure);
  motion_.add({8, 8, 42, 20});
  make();
  fuse();
  ASSERT_EQ(found().size(), 2U);
  EXPECT_EQ(found()[0].class_id, kVehicleClass);
  EXPECT_EQ(found()[1].class_id, kPedestrianClass);
  EXPECT_EQ(at(29, 15), 1);
  EXPECT_EQ(at(30, 15), 2);
  expect_consistent();
}

TEST_F(MaskFusionTest, ARegionOfWhichTheNetworkSeesLittleIsOneBesideIt) {
  network_.add({10, 10, 14, 30}, kPedestrianClass, kSure);
  motion_.add({10, 10, 50, 30});
  make();
  fuse();
  ASSERT_EQ(found().size(), 2U);
  EXPECT_EQ(found()[0].class_id, kUnknownClass);
  EXPECT_EQ(found()[0].area_px, 36 * 20);
  EXPECT_EQ(found()[1].area_px, 4 * 20);
  expect_consistent();
}

TEST_F(MaskFusionTest, AMovingTrunkIsAPartOfThePersonWhoseLegsTheNetworkFound) {
  network_.add({10, 20, 18, 30}, kPedestrianClass, kSure);
  motion_.add_moving({8, 12, 18, 21});
  make();
  fuse();
  ASSERT_EQ(found().size(), 1U);
  EXPECT_EQ(found()[0].class_id, kPedestrianClass);
  EXPECT_EQ(found()[0].area_px, 80) << "with the network's contour";
  EXPECT_TRUE(found()[0].moving);
  expect_consistent();
}

TEST_F(MaskFusionTest, ARegionThatDoesNotFitIntoThePersonIsAnother) {
  network_.add({10, 20, 18, 30}, kPedestrianClass, kSure);
  motion_.add_moving({8, 5, 28, 21});  // a diagonal of 32 pixels
  make();
  fuse();
  ASSERT_EQ(found().size(), 2U);
  EXPECT_EQ(found()[0].class_id, kUnknownClass);
  EXPECT_FALSE(found()[1].moving);
  expect_consistent();
}

TEST_F(MaskFusionTest, ARegionBesideAPersonIsAnother) {
  network_.add({10, 20, 18, 30}, kPedestrianClass, kSure);
  motion_.add_moving({18, 15, 24, 30});  // fits, but touches it only
  make();
  fuse();
  EXPECT_EQ(found().size(), 2U);
}

TEST_F(MaskFusionTest, ARegionThatOverlapsAVehicleIsNoPartOfIt) {
  network_.add({10, 20, 18, 30}, kVehicleClass, kSure);
  motion_.add_moving({8, 12, 18, 21});
  make();
  fuse();
  EXPECT_EQ(found().size(), 2U);
}

TEST_F(MaskFusionTest, WhatIsToBeIgnoredStaysSo) {
  network_.ignore({0, 0, kWidth, 12});
  network_.ignore({60, 0, 90, 40});
  motion_.add({10, 10, 30, 20});
  motion_.add({60, 20, 90, 40});
  make();
  fuse();
  ASSERT_EQ(found().size(), 1U) << "the other one is of no interest";
  EXPECT_EQ(found()[0].box_px.y0, 12);
  EXPECT_EQ(at(15, 11), kIgnoreLabel);
  EXPECT_EQ(at(70, 30), kIgnoreLabel);
  expect_consistent();
}

TEST_F(MaskFusionTest, ACandidateMovesWhereMostOfItIsOnAMovingRegion) {
  make();
  network_.add({10, 5, 30, 25}, kVehicleClass, kSure);
  network_.add({40, 5, 60, 25}, kVehicleClass, kSure);
  network_.add({70, 5, 90, 25}, kVehicleClass, kSure);
  motion_.add_moving({10, 5, 25, 25});
  motion_.add_moving({40, 5, 48, 25});
  motion_.add({70, 5, 90, 25});  // halted
  fuse();
  ASSERT_EQ(found().size(), 3U);
  EXPECT_TRUE(found()[0].moving);
  EXPECT_FALSE(found()[1].moving);
  EXPECT_FALSE(found()[2].moving);
}

TEST_F(MaskFusionTest, ARegionMovesAsSegmentationSays) {
  make();
  motion_.add_moving({10, 5, 30, 25});
  motion_.add({40, 5, 50, 25});
  fuse();
  ASSERT_EQ(found().size(), 2U);
  EXPECT_TRUE(found()[0].moving);
  EXPECT_FALSE(found()[1].moving);
}

TEST_F(MaskFusionTest, AsManyAsThereIsRoomForStayAndTheSmallestGoes) {
  for (int i = 0; i < 4; ++i) {
    (i % 2 == 0 ? network_ : motion_).add({20 * i, 0, 20 * i + 10 + i, 10}, kUnknownClass, 0.99F);
  }
  make(4);
  EXPECT_EQ(fuse(), 0);
  EXPECT_EQ(found().size(), 4U);
  make(3);
  EXPECT_EQ(fuse(), 1);
  EXPECT_EQ(found().size(), 3U);
  EXPECT_EQ(found()[0].box_px.x0, 60) << "the largest first";
  EXPECT_EQ(at(5, 5), kIgnoreLabel) << "something is there";
  expect_consistent();
}

TEST_F(MaskFusionTest, HoldsAsManyOfBothAsThereAreLabels) {
  for (int i = 0; i < kMaxObjects; ++i) {
    const int x = i % 32 * 3;
    const int y = i / 32 * 4;
    network_.add({x, y, x + 2, y + 2}, kVehicleClass, kSure);
    motion_.add({x, y + 20, x + 2, y + 22});
  }
  make();
  EXPECT_EQ(fuse(), kMaxObjects);
  ASSERT_EQ(found().size(), static_cast<std::size_t>(kMaxObjects));
  EXPECT_EQ(found().back().class_id, kVehicleClass) << "of equal size, what has a class stays";
  expect_consistent();
}

TEST_F(MaskFusionTest, WhatIsTooSmallIsBackgroundAndCounted) {
  network_.add({0, 0, 3, 3}, kVehicleClass, kSure);
  motion_.add({40, 0, 43, 3});
  make(4, 9);
  EXPECT_EQ(fuse(), 0);
  EXPECT_EQ(found().size(), 2U);
  make(4, 10);
  EXPECT_EQ(fuse(), 2);
  EXPECT_TRUE(found().empty());
  EXPECT_EQ(at(1, 1), kBackgroundLabel);
}

TEST_F(MaskFusionTest, OneImageLeavesNothingToTheNext) {
  network_.add({10, 10, 30, 20}, kVehicleClass, kSure);
  make();
  fuse();
  network_ = {};
  motion_.add({50, 10, 60, 20});
  fuse();
  ASSERT_EQ(found().size(), 1U);
  EXPECT_EQ(at(15, 15), kBackgroundLabel);
  expect_consistent();
}

}  // namespace
}  // namespace kinetrace::segmentation

// Masks that overlap in one image.
#include "kinetrace/segmentation/mask_canvas.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::segmentation {
namespace {

constexpr StereoGeometry kGeometry{
    .fx_px = 100.0, .fy_px = 100.0, .cx_px = 20.0, .cy_px = 10.0, .baseline_m = 0.5, .width_px = 40, .height_px = 20};

class MaskCanvasTest : public ::testing::Test {
 protected:
  MaskCanvasTest() { config_.min_area_px = 1; }

  /// Adds a mask that fills its box.
  void add(std::uint16_t class_id, const PixelBox& box) {
    runs_.push_back(std::make_unique<std::vector<std::uint16_t>>(
        std::vector<std::uint16_t>{0, static_cast<std::uint16_t>(box.width() * box.height())}));
    masks_.push_back({class_id, 0.9F, box, *runs_.back()});
  }

  std::span<const Detection> detections_of(void (MaskCanvas::*draw)(std::span<const RunLengthMask>) noexcept) {
    (canvas_.*draw)(masks_);
    (void)canvas_.finish(config_, relabeler_);
    return canvas_.detections();
  }

  [[nodiscard]] int count(std::uint8_t label) const {
    int pixels = 0;
    for (int y = 0; y < kGeometry.height_px; ++y) {
      const std::uint8_t* const row = canvas_.labels().row(y);
      pixels += static_cast<int>(std::count(row, row + kGeometry.width_px, label));
    }
    return pixels;
  }

  SegmentationConfig config_;
  Arena arena_{1U << 20U};
  InstanceRelabeler relabeler_{arena_};
  MaskCanvas canvas_{kGeometry, 8, arena_};
  std::vector<std::unique_ptr<std::vector<std::uint16_t>>> runs_;
  std::vector<RunLengthMask> masks_;
};

TEST_F(MaskCanvasTest, MasksOfASenderAreDrawnInItsOrder) {
  add(kVehicleClass, {0, 0, 20, 10});
  add(kVehicleClass, {0, 4, 20, 14});
  add(kPedestrianClass, {8, 2, 12, 16});
  const std::span<const Detection> found = detections_of(&MaskCanvas::draw);
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].area_px, 200);
  EXPECT_EQ(found[1].area_px, 80);
  EXPECT_EQ(found[2].area_px, 8);
}

TEST_F(MaskCanvasTest, StrongerCandidatesCoverWeakerOnes) {
  add(kVehicleClass, {0, 0, 20, 10});
  add(kVehicleClass, {15, 0, 30, 10});
  const std::span<const Detection> found = detections_of(&MaskCanvas::draw_candidates);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].area_px, 200);
  EXPECT_EQ(found[1].area_px, 100);
}

// Two boxes of one car, that overlap too little for the suppression of boxes.
TEST_F(MaskCanvasTest, ASecondMaskOfAnObjectLeavesNoFragment) {
  for (const std::uint16_t second : {kVehicleClass, kUnknownClass}) {
    masks_.clear();
    add(kVehicleClass, {0, 0, 20, 10});
    add(second, {0, 4, 20, 14});
    const std::span<const Detection> found = detections_of(&MaskCanvas::draw_candidates);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].area_px, 200);
    EXPECT_EQ(count(kIgnoreLabel), 80) << "neither an object nor background";
  }
}

TEST_F(MaskCanvasTest, APersonStandsInFrontOfTheVehicleThatHasMostOfItsPixels) {
  add(kVehicleClass, {0, 0, 20, 10});
  add(kPedestrianClass, {8, 2, 12, 12});
  const std::span<const Detection> found = detections_of(&MaskCanvas::draw_candidates);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].area_px, 200 - 32);
  EXPECT_EQ(found[1].area_px, 40);
  EXPECT_EQ(found[1].class_id, kPedestrianClass);
}

TEST_F(MaskCanvasTest, IgnoredPixelsStayIgnoredAndCoverNothing) {
  add(kIgnoreClass, {0, 0, 20, 10});
  add(kVehicleClass, {0, 0, 20, 12});
  add(kIgnoreClass, {0, 10, 10, 12});
  const std::span<const Detection> found = detections_of(&MaskCanvas::draw_candidates);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].area_px, 40);
  EXPECT_EQ(count(kIgnoreLabel), 200);
}

}  // namespace
}  // namespace kinetrace::segmentation

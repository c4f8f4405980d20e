#include "kinetrace/segmentation/region_chooser.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::segmentation {
namespace {

constexpr StereoGeometry kGeometry{.fx_px = 500.0,
                                   .fy_px = 500.0,
                                   .cx_px = 320.0,
                                   .cy_px = 100.0,
                                   .baseline_m = 0.5,
                                   .width_px = 640,
                                   .height_px = 200};

Track track(std::uint32_t id, const PixelBox& box) {
  return {.id = id, .slot = static_cast<std::uint8_t>(id - 1), .box_px = box};
}

void expect_in(const PixelBox& box, const PixelBox& region, int margin_px) {
  EXPECT_GE(box.x0, region.x0 + margin_px);
  EXPECT_GE(box.y0, region.y0 + margin_px);
  EXPECT_LE(box.x1, region.x1 - margin_px);
  EXPECT_LE(box.y1, region.y1 - margin_px);
}

void expect_in_image(const PixelBox& region) {
  EXPECT_EQ(region.width(), 320);
  EXPECT_EQ(region.height(), 100);
  EXPECT_GE(region.x0, 0);
  EXPECT_GE(region.y0, 0);
  EXPECT_LE(region.x1, 640);
  EXPECT_LE(region.y1, 200);
}

TEST(RegionChooser, ATrackAloneIsInTheMiddle) {
  RegionChooser chooser(kGeometry);
  const std::vector<Track> tracks{track(1, {300, 90, 340, 110})};
  const PixelBox region = chooser.choose(tracks);
  expect_in_image(region);
  EXPECT_EQ(region.x0 + region.x1, 640);
  EXPECT_EQ(region.y0 + region.y1, 200);
}

TEST(RegionChooser, TracksFarApartTakeTurns) {
  RegionChooser chooser(kGeometry);
  const std::vector<Track> tracks{track(1, {40, 90, 70, 110}), track(2, {580, 90, 610, 110})};
  for (int turn = 0; turn < 2; ++turn) {
    for (const Track& expected : tracks) {
      const PixelBox region = chooser.choose(tracks);
      expect_in_image(region);
      expect_in(expected.box_px, region, 8);
    }
  }
}

TEST(RegionChooser, NeighboursAreTakenIn) {
  RegionChooser chooser(kGeometry);
  const std::vector<Track> tracks{track(1, {100, 60, 130, 80}), track(2, {330, 70, 360, 110}),
                                  track(3, {600, 90, 620, 110})};
  const PixelBox region = chooser.choose(tracks);
  expect_in(tracks[0].box_px, region, 8);
  expect_in(tracks[1].box_px, region, 8);
  const PixelBox next = chooser.choose(tracks);
  expect_in(tracks[2].box_px, next, 8);
}

TEST(RegionChooser, AtTheBorderOfTheImageNoMarginIsNeeded) {
  RegionChooser chooser(kGeometry);
  const std::vector<Track> tracks{track(1, {0, 120, 270, 200})};
  const PixelBox region = chooser.choose(tracks);
  expect_in_image(region);
  EXPECT_EQ(region.x0, 0);
  EXPECT_EQ(region.y1, 200);
}

TEST(RegionChooser, WhatIsLargerThanARegionNeedsNone) {
  RegionChooser chooser(kGeometry);
  const std::vector<Track> tracks{track(1, {100, 20, 300, 120}), track(2, {})};
  EXPECT_TRUE(chooser.choose(tracks).empty());
  EXPECT_TRUE(chooser.choose({}).empty());
}

TEST(RegionChooser, AnotherTrackInTheSlotHasWaitedSinceEver) {
  RegionChooser chooser(kGeometry);
  std::vector<Track> tracks{track(1, {40, 90, 70, 110}), track(2, {580, 90, 610, 110})};
  expect_in(tracks[0].box_px, chooser.choose(tracks), 8);
  tracks[0].id = 9;
  expect_in(tracks[0].box_px, chooser.choose(tracks), 8);
  expect_in(tracks[1].box_px, chooser.choose(tracks), 8);
}

}  // namespace
}  // namespace kinetrace::segmentation

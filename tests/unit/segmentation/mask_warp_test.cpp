#include "kinetrace/segmentation/mask_warp.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "moving_picture.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr StereoGeometry kGeometry{
    .fx_px = 200.0, .fy_px = 200.0, .cx_px = 80.0, .cy_px = 60.0, .baseline_m = 0.5, .width_px = 160, .height_px = 120};
constexpr int kFeatures = 200;

class MaskWarpTest : public ::testing::Test {
 protected:
  MaskWarpTest() { config_.min_area_px = 1; }

  void draw(const std::vector<PixelBox>& boxes) {
    masks_.clear();
    runs_.clear();
    for (const PixelBox& box : boxes) {
      runs_.push_back(std::make_unique<std::vector<std::uint16_t>>(
          std::vector<std::uint16_t>{0, static_cast<std::uint16_t>(box.width() * box.height())}));
      masks_.push_back({kVehicleClass, 1.F, box, *runs_.back()});
    }
    canvas_.draw(masks_);
  }
  /// Features on a grid in `box`, moved by `motion`, with disparity 10 before and `disparity` now.
  template <typename Motion>
  void features_in(const PixelBox& box, Motion&& motion, float disparity = 10.F, int step = 4) {
    for (int y = box.y0 + step / 2; y < box.y1; y += step) {
      for (int x = box.x0 + step / 2; x < box.x1; x += step) {
        Feature feature;
        feature.id = static_cast<std::uint32_t>(then_.size() + 1);
        feature.slot = static_cast<std::uint16_t>(then_.size());
        feature.left_px = {static_cast<float>(x), static_cast<float>(y)};
        feature.u_right_px = feature.left_px.x() - 10.F;
        then_.push_back(feature);
        feature.left_px = motion(feature.left_px);
        feature.u_right_px = feature.left_px.x() - disparity;
        now_.push_back(feature);
      }
    }
  }
  std::vector<Detection> warped(View view = View::kLeft) {
    warp_.remember(then_picture_.pair(0, 0));
    seen_.remember(then_);
    warp_.warp(seen_.by_slot(), input(now_picture_, 100'000'000, now_), view, canvas_);
    static_cast<void>(canvas_.finish(config_, relabeler_));
    return {canvas_.detections().begin(), canvas_.detections().end()};
  }
  static SegmentationInput input(const test::MovingPicture& picture, std::int64_t timestamp_ns,
                                 std::span<const Feature> features) {
    SegmentationInput input;
    input.pair = picture.pair(0, timestamp_ns);
    input.features = features;
    return input;
  }
  static void expect_near(const PixelBox& box, const PixelBox& expected, int tolerance_px = 1) {
    EXPECT_NEAR(box.x0, expected.x0, tolerance_px);
    EXPECT_NEAR(box.y0, expected.y0, tolerance_px);
    EXPECT_NEAR(box.x1, expected.x1, tolerance_px);
    EXPECT_NEAR(box.y1, expected.y1, tolerance_px);
  }

  SegmentationConfig config_;
  Arena arena_{1 << 22};
  MaskCanvas canvas_{kGeometry, 8, arena_};
  MaskWarp warp_{kGeometry, kFeatures, true, arena_};
  SeenFeatures seen_{kFeatures, arena_};
  test::MovingPicture then_picture_{kGeometry, 0.0};  // Grey, unless drawn.
  test::MovingPicture now_picture_{kGeometry, 0.0};
  InstanceRelabeler relabeler_{arena_};
  std::vector<RunLengthMask> masks_;
  std::vector<std::unique_ptr<std::vector<std::uint16_t>>> runs_;
  std::vector<Feature> then_;
  std::vector<Feature> now_;
};

TEST_F(MaskWarpTest, AMaskMovesWithItsFeatures) {
  const PixelBox box{20, 30, 60, 60};
  draw({box});
  features_in(box, [](const Eigen::Vector2f& p) -> Eigen::Vector2f { return p + Eigen::Vector2f(12.F, -7.F); });
  const auto found = warped();
  ASSERT_EQ(found.size(), 1U);
  expect_near(found[0].box_px, {32, 23, 72, 53}, 0);
  EXPECT_EQ(found[0].area_px, 40 * 30);
}

TEST_F(MaskWarpTest, AMaskGrowsWithItsFeatures) {
  const PixelBox box{20, 30, 60, 60};
  draw({box});
  features_in(box, [](const Eigen::Vector2f& p) -> Eigen::Vector2f { return 1.2F * p - Eigen::Vector2f(8.F, 9.F); });
  const auto found = warped();
  ASSERT_EQ(found.size(), 1U);
  expect_near(found[0].box_px, {16, 27, 64, 63});
  EXPECT_NEAR(found[0].area_px, 48 * 36, 100);
}

TEST_F(MaskWarpTest, FeaturesThatGoTheirOwnWayHaveNoSay) {
  const PixelBox box{20, 30, 60, 60};
  draw({box});
  int count = 0;
  features_in(box, [&](const Eigen::Vector2f& p) -> Eigen::Vector2f {
    return ++count % 3 == 0 ? p : p + Eigen::Vector2f(12.F, -7.F);  // A third lies on the background.
  });
  expect_near(warped()[0].box_px, {32, 23, 72, 53});
}

TEST_F(MaskWarpTest, TwoMasksMoveApart) {
  const PixelBox first{20, 30, 50, 60};
  const PixelBox second{90, 30, 120, 60};
  draw({first, second});
  features_in(first, [](const Eigen::Vector2f& p) -> Eigen::Vector2f { return p - Eigen::Vector2f(10.F, 0.F); });
  features_in(second, [](const Eigen::Vector2f& p) -> Eigen::Vector2f { return p + Eigen::Vector2f(10.F, 0.F); });
  const auto found = warped();
  ASSERT_EQ(found.size(), 2U);
  expect_near(found[0].box_px, {10, 30, 40, 60}, 0);
  expect_near(found[1].box_px, {100, 30, 130, 60}, 0);
}

TEST_F(MaskWarpTest, WithoutFeaturesItGoesWithWhatIsAround) {
  const PixelBox box{60, 50, 70, 60};
  draw({box});
  features_in({20, 30, 50, 80},
              [](const Eigen::Vector2f& p) -> Eigen::Vector2f { return p + Eigen::Vector2f(5.F, 3.F); });
  expect_near(warped()[0].box_px, {65, 53, 75, 63}, 0);
}

TEST_F(MaskWarpTest, WithoutFeaturesTheImagesShowWhereItIs) {
  const PixelBox box{60, 40, 76, 80};
  draw({box});
  then_picture_.draw({60, 40, 16, 40, 10.0});
  now_picture_.draw({71, 38, 16, 40, 10.0});
  expect_near(warped()[0].box_px, {71, 38, 87, 78}, 0);
}

TEST_F(MaskWarpTest, WithoutFeaturesTheImagesOfItsOwnViewCount) {
  draw({{50, 40, 66, 80}});
  then_picture_.draw({60, 40, 16, 40, 10.0});
  now_picture_.draw({70, 40, 16, 40, 13.0});
  expect_near(warped(View::kRight)[0].box_px, {57, 40, 73, 80}, 0);
}

TEST_F(MaskWarpTest, APlainOneGoesWhereItsBrightnessIs) {
  const PixelBox box{60, 40, 76, 80};
  draw({box});
  then_picture_.draw({60, 40, 16, 40, 10.0}, true);
  now_picture_.draw({52, 41, 16, 40, 10.0}, true);
  expect_near(warped()[0].box_px, {52, 41, 68, 81});
}

TEST_F(MaskWarpTest, FeaturesAroundTellWhereToSearch) {
  const PixelBox box{60, 40, 76, 80};
  draw({box});
  then_picture_.draw({60, 40, 16, 40, 10.0});
  now_picture_.draw({100, 40, 16, 40, 10.0});  // Further than an object moves by itself in a tenth of a second.
  features_in({20, 30, 50, 90},
              [](const Eigen::Vector2f& p) -> Eigen::Vector2f { return p + Eigen::Vector2f(36.F, 0.F); });
  expect_near(warped()[0].box_px, {100, 40, 116, 80}, 0);
}

TEST_F(MaskWarpTest, WithoutAnyFeatureItStays) {
  draw({{60, 50, 70, 60}});
  expect_near(warped()[0].box_px, {60, 50, 70, 60}, 0);
}

TEST_F(MaskWarpTest, AFeatureThatIsAnotherNowIsNotFollowed) {
  const PixelBox box{20, 30, 60, 60};
  draw({box});
  features_in(box, [](const Eigen::Vector2f& p) -> Eigen::Vector2f { return p + Eigen::Vector2f(12.F, 0.F); });
  for (Feature& feature : now_) {
    feature.id += 1000;  // Other features use the slots now.
  }
  expect_near(warped()[0].box_px, box, 0);
}

TEST_F(MaskWarpTest, InTheRightImageDisparityCounts) {
  const PixelBox box{20, 30, 60, 60};
  draw({box});
  features_in(
      {30, 30, 70, 60}, [](const Eigen::Vector2f& p) -> Eigen::Vector2f { return p + Eigen::Vector2f(4.F, 0.F); },
      13.F);
  expect_near(warped(View::kRight)[0].box_px, {21, 30, 61, 60}, 0);
}

TEST_F(MaskWarpTest, WhatLeavesThePictureIsCutOrGone) {
  const PixelBox box{120, 30, 150, 60};
  draw({box});
  features_in(box, [](const Eigen::Vector2f& p) -> Eigen::Vector2f { return p + Eigen::Vector2f(20.F, 0.F); });
  expect_near(warped()[0].box_px, {140, 30, 160, 60}, 0);
  then_.clear();
  now_.clear();
  draw({box});
  features_in(box, [](const Eigen::Vector2f& p) -> Eigen::Vector2f { return p + Eigen::Vector2f(90.F, 0.F); });
  EXPECT_TRUE(warped().empty());
}

}  // namespace
}  // namespace kinetrace::segmentation

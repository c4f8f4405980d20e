// Warnings about masks that belong to other images.
#include "segmentation/mask_fit_watch.hpp"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "wall_for_test.hpp"

namespace kinetrace::app {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr PixelBox kObject{140, 60, 200, 180};
constexpr int kDisparity_px = 12;

using Image = std::vector<std::uint8_t>;

bool is_object(int x, int y) {
  return x >= kObject.x0 && x < kObject.x1 && y >= kObject.y0 && y < kObject.y1;
}

/// A bright object, `left_px` further left, before a textured wall.
Image image(int left_px) {
  Image pixels = hal::test::wall(kWidth, kHeight, 0.0, 0.0);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      std::uint8_t& pixel = pixels[static_cast<std::size_t>(y * kWidth + x)];
      pixel = static_cast<std::uint8_t>(is_object(x + left_px, y) ? 200 + pixel / 8 : pixel / 4);
    }
  }
  return pixels;
}

class MaskFitWatchTest : public testing::Test {
 protected:
  /// Plays frames whose masks lie `left_px` further left than the object does in the left image.
  Status play(int left_px, std::uint64_t missing_per_frame = 0, InputPolicy policy = InputPolicy::kStop) {
    MaskFitWatch watch(policy, "mask folder m");
    const Image left = image(0);
    const Image right = image(kDisparity_px);
    Track track;
    track.box_px = {kObject.x0 - left_px, kObject.y0, kObject.x1 - left_px, kObject.y1};
    Image labels(left.size(), kBackgroundLabel);
    for (int y = track.box_px.y0; y < track.box_px.y1; ++y) {
      for (int x = track.box_px.x0; x < track.box_px.x1; ++x) {
        labels[static_cast<std::size_t>(y * kWidth + x)] = track.label();
      }
    }
    FrameResult result;
    result.pair.left = {left.data(), kWidth, kHeight, kWidth};
    result.pair.right = {right.data(), kWidth, kHeight, kWidth};
    result.left_labels = {labels.data(), kWidth, kHeight, kWidth};
    result.tracks = {&track, 1};
    for (int frame = 0; frame < 20; ++frame) {
      result.newest.timestamp_ns = frame * 100'000'000LL;
      result.counters.detection_frames_missing += missing_per_frame;
      if (Status status = watch.process(result, health_, warn_); !status) {
        return status;
      }
    }
    return {};
  }
  std::uint64_t noted(HealthReason reason) const { return health_.all()[static_cast<std::size_t>(reason)].count; }

  HealthMonitor health_;
  std::vector<std::string> said_;
  Warn warn_ = [this](const std::string& warning) { said_.push_back(warning); };
};

TEST_F(MaskFitWatchTest, SaysNothingOfMasksUpToThreePixelsOff) {
  for (const int error_px : {-3, 0, 3}) {
    EXPECT_TRUE(play(error_px));
  }
  EXPECT_THAT(said_, ElementsAre());
  EXPECT_EQ(health_.worst(), HealthState::kOk);
}

TEST_F(MaskFitWatchTest, MasksOfTheRightImageEndTheRun) {
  const Status status = play(kDisparity_px);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kBadFormat);
  EXPECT_THAT(status.error().message, AllOf(HasSubstr("mask folder m"), HasSubstr("right images")));
  EXPECT_EQ(noted(HealthReason::kMasksExchanged), 1U);
}

TEST_F(MaskFitWatchTest, OrAreSaidOnceAndNotedAsLongAsTheyLast) {
  EXPECT_TRUE(play(kDisparity_px, 0, InputPolicy::kWarn));
  EXPECT_THAT(said_, ElementsAre(HasSubstr("right images")));
  EXPECT_GT(noted(HealthReason::kMasksExchanged), 10U);
}

TEST_F(MaskFitWatchTest, MasksOfOtherImagesAreSaidOnce) {
  EXPECT_TRUE(play(-90));
  EXPECT_THAT(said_, ElementsAre(HasSubstr("other images")));
  EXPECT_GT(noted(HealthReason::kMasksUnrelated), 10U);
}

TEST_F(MaskFitWatchTest, PredictedMasksAreNoEvidence) {
  EXPECT_TRUE(play(-90, 1));
  EXPECT_THAT(said_, ElementsAre());
}

}  // namespace
}  // namespace kinetrace::app

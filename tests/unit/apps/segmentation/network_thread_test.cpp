#include "segmentation/network_thread.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>
#include <sys/resource.h>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::app {
namespace {

constexpr StereoGeometry kGeometry{
    .fx_px = 100.0, .fy_px = 100.0, .cx_px = 64.0, .cy_px = 32.0, .baseline_m = 0.5, .width_px = 128, .height_px = 64};

NetworkThreadConfig config(bool waits, bool right = false) {
  NetworkThreadConfig made;
  made.model.family = neural::ModelFamily::kYolov8Seg;
  made.model.file = std::string(KINETRACE_MODELS) + "/yolov8-seg.onnx";
  made.model.input.width_px = kGeometry.width_px;
  made.model.input.height_px = kGeometry.height_px;
  made.model.classes = {{"white", kVehicleClass, 0.5F}, {"red", kPedestrianClass, 0.5F}};
  made.model.thresholds.overlap = 0.45F;
  made.runtime = KINETRACE_RUNTIME;
  made.waits = waits;
  made.right = right;
  return made;
}

/// A bright square, at different places in both views.
class Pictures {
 public:
  Pictures() : left_(pixels(72)), right_(pixels(56)) {}
  [[nodiscard]] RectifiedPair pair(bool is_dark = false) const {
    const auto view = [](const std::vector<std::uint8_t>& image) {
      return GrayView{image.data(), kGeometry.width_px, kGeometry.height_px, kGeometry.width_px};
    };
    RectifiedPair pair;
    pair.left = view(is_dark ? dark_ : left_);
    pair.right = view(is_dark ? dark_ : right_);
    pair.geometry = kGeometry;
    return pair;
  }

 private:
  static std::vector<std::uint8_t> pixels(int x0) {
    std::vector<std::uint8_t> image(static_cast<std::size_t>(kGeometry.width_px * kGeometry.height_px), 10);
    for (int y = 16; y < 32; ++y) {
      std::fill_n(image.begin() + static_cast<std::ptrdiff_t>(y) * kGeometry.width_px + x0, 16, std::uint8_t{250});
    }
    return image;
  }
  std::vector<std::uint8_t> left_;
  std::vector<std::uint8_t> right_;
  std::vector<std::uint8_t> dark_ =
      std::vector<std::uint8_t>(static_cast<std::size_t>(kGeometry.width_px * kGeometry.height_px), 10);
};

TEST(NetworkThread, AnswersForBothCameras) {
  const auto network = NetworkThread::create(config(true, true), kGeometry);
  ASSERT_TRUE(network) << network.error().message;
  const Pictures pictures;
  (*network)->offer(pictures.pair(), {});
  const DelayedMasks masks = (*network)->take();
  ASSERT_TRUE(masks.done);
  ASSERT_NE(masks.masks, nullptr);
  ASSERT_EQ(masks.masks->left.size(), 1U);
  ASSERT_EQ(masks.masks->right.size(), 1U);
  EXPECT_EQ(masks.masks->left[0].box_px.x0 - masks.masks->right[0].box_px.x0, 16);
  EXPECT_EQ((*network)->counters().frames, 1U);
  EXPECT_GT((*network)->counters().median_ms, 0.0);
}

// The network sees nothing but large disparities.
TEST(NetworkThread, GivesTheNetworkBothViewsForDisparities) {
  NetworkThreadConfig stereo = config(true);
  stereo.model.family = neural::ModelFamily::kKinetraceSeg;
  stereo.model.file = std::string(KINETRACE_MODELS) + "/kinetrace-seg-stereo.onnx";
  stereo.model.input.colours = neural::InputColours::kGray;
  stereo.model.input.disparity = true;
  const auto network = NetworkThread::create(stereo, kGeometry);
  ASSERT_TRUE(network) << network.error().message;
  constexpr int kShift_px = 24;
  const auto textured = [](int shift_px) {
    std::vector<std::uint8_t> image;
    for (int y = 0; y < kGeometry.height_px; ++y) {
      for (int x = shift_px; x < kGeometry.width_px + shift_px; ++x) {
        const unsigned mixed = static_cast<unsigned>(x / 2 * 7919 + y / 2 * 104729) * 2654435761U;
        image.push_back(static_cast<std::uint8_t>(mixed >> 24U));
      }
    }
    return image;
  };
  const std::vector<std::uint8_t> left = textured(0);
  const std::vector<std::uint8_t> right = textured(kShift_px);
  const auto view = [](const std::vector<std::uint8_t>& image) {
    return GrayView{image.data(), kGeometry.width_px, kGeometry.height_px, kGeometry.width_px};
  };
  RectifiedPair pair;
  pair.left = view(left);
  pair.right = view(right);
  pair.geometry = kGeometry;
  (*network)->offer(pair, {});
  EXPECT_FALSE((*network)->take().masks->left.empty());
  pair.right = view(left);
  (*network)->offer(pair, {});
  EXPECT_TRUE((*network)->take().masks->left.empty());
}

TEST(NetworkThread, OfARegionOnlyWhatTheLeftCameraSeesThere) {
  const auto network = NetworkThread::create(config(true, true), kGeometry);
  ASSERT_TRUE(network) << network.error().message;
  const Pictures pictures;
  (*network)->offer(pictures.pair(), {32, 0, 128, 64});
  const DelayedMasks with = (*network)->take();
  ASSERT_EQ(with.masks->left.size(), 1U);
  const PixelBox& box = with.masks->left[0].box_px;
  EXPECT_NEAR(0.5 * (box.x0 + box.x1), 80.0, 8.0) << "in the whole image; to a cell of the network";
  EXPECT_TRUE(with.masks->right.empty());
  (*network)->offer(pictures.pair(), {0, 0, 64, 64});
  EXPECT_TRUE((*network)->take().masks->left.empty());
  (*network)->offer(pictures.pair(), {});
  EXPECT_EQ((*network)->take().masks->right.size(), 1U) << "the whole image is looked at with both views again";
}

TEST(NetworkThread, AnAnswerStaysWhileTheNextFrameIsWorkedOn) {
  const auto network = NetworkThread::create(config(true), kGeometry);
  ASSERT_TRUE(network) << network.error().message;
  const Pictures pictures;
  (*network)->offer(pictures.pair(), {});
  const DelayedMasks first = (*network)->take();
  (*network)->offer(pictures.pair(true), {});
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ASSERT_EQ(first.masks->left.size(), 1U);
  EXPECT_TRUE(fits(first.masks->left[0], kGeometry.width_px, kGeometry.height_px));
  EXPECT_TRUE((*network)->take().masks->left.empty());
}

TEST(NetworkThread, ACameraDoesNotWait) {
  const auto network = NetworkThread::create(config(false), kGeometry);
  ASSERT_TRUE(network) << network.error().message;
  const Pictures pictures;
  (*network)->offer(pictures.pair(), {});
  DelayedMasks masks;
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!masks.done && std::chrono::steady_clock::now() < give_up) {
    masks = (*network)->take();
  }
  ASSERT_TRUE(masks.done);
  EXPECT_EQ(masks.masks->left.size(), 1U);
}

TEST(NetworkThread, FramesHaveTheProcessorFirst) {
  const auto made = NetworkThread::create(config(true), kGeometry);
  ASSERT_TRUE(made) << made.error().message;
  const int own = ::getpriority(PRIO_PROCESS, 0);
  int nicest = own;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task")) {
    const int id = std::stoi(thread.path().filename().string());
    nicest = std::max(nicest, ::getpriority(PRIO_PROCESS, static_cast<id_t>(id)));
  }
  constexpr int kNicestOfAll = 19;
  if (own == kNicestOfAll) {
    GTEST_SKIP() << "the test has no priority to give up";
  }
  EXPECT_GT(nicest, own);
}

TEST(NetworkThread, WhatIsUnderWayAtTheEndIsNotWaitedForLong) {
  const Pictures pictures;
  for (int i = 0; i < 20; ++i) {
    const auto network = NetworkThread::create(config(false), kGeometry);
    ASSERT_TRUE(network) << network.error().message;
    (*network)->offer(pictures.pair(), {});
  }
}

TEST(NetworkThread, WhatIsWrongWithTheModelIsSaidAtTheStart) {
  NetworkThreadConfig wrong = config(true);
  wrong.model.file = std::string(KINETRACE_MODELS) + "/nan-weights.onnx";
  const auto network = NetworkThread::create(wrong, kGeometry);
  ASSERT_FALSE(network);
  EXPECT_EQ(network.error().code, ErrorCode::kBadFormat);
}

// Its runtime never answers.
TEST(NetworkThread, ANetworkThatHangsIsLeftBehind) {
  NetworkThreadConfig hanging = config(true);
  hanging.runtime = KINETRACE_HANGING_RUNTIME;
  hanging.timeout = std::chrono::milliseconds(100);
  const auto begun = std::chrono::steady_clock::now();
  {
    const auto network = NetworkThread::create(hanging, kGeometry);
    ASSERT_TRUE(network) << network.error().message;
    const Pictures pictures;
    (*network)->offer(pictures.pair(), {});
    EXPECT_FALSE((*network)->take().done) << "waited for once";
    const auto waited = std::chrono::steady_clock::now();
    for (int i = 0; i < 100; ++i) {
      EXPECT_FALSE((*network)->take().done);
    }
    EXPECT_LT(std::chrono::steady_clock::now() - waited, std::chrono::seconds(5)) << "and not again";
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(20));
}

}  // namespace
}  // namespace kinetrace::app

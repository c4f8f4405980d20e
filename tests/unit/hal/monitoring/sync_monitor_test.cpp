// A textured wall before a nodding rig: the moment of each view is known.
#include "kinetrace/hal/sync_monitor.hpp"

#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "wall_for_test.hpp"

namespace kinetrace::hal {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

std::vector<std::uint8_t> wall(double right_px, double down_px, bool blank) {
  return blank ? std::vector<std::uint8_t>(std::size_t{kWidth} * kHeight, 128)
               : test::wall(kWidth, kHeight, right_px, down_px);
}

struct Rig {
  std::function<double(int)> nod = [](int frame) { return 6.0 * std::sin(frame * 0.9); };  ///< Rows, by frame.
  std::function<double(int)> slide = [](int /*frame*/) { return 0.0; };                    ///< Columns.
  int right_lag = 0;         ///< Delay of the right image in frames; negative: of the left one.
  double misaligned_px = 0;  ///< Vertical offset of the right view, downwards.
  bool blank = false;
  int kept_every = 1;  ///< The other frames do not arrive.
};

SyncReport watch(const Rig& rig, int frames = 80) {
  Arena arena(SyncMonitor::required_bytes({}, kWidth, kHeight));
  SyncMonitor monitor = SyncMonitor::create({.interval_frames = 4}, kWidth, kHeight, arena).value();
  constexpr double kDisparity = 24.0;
  for (int frame = 0; frame < frames; ++frame) {
    if (frame % rig.kept_every != 0) {
      continue;
    }
    const int left_shot = frame + std::min(rig.right_lag, 0);
    const int right_shot = frame - std::max(rig.right_lag, 0);
    const auto left = wall(rig.slide(left_shot), rig.nod(left_shot), rig.blank);
    const auto right = wall(rig.slide(right_shot) + kDisparity, rig.nod(right_shot) - rig.misaligned_px, rig.blank);
    monitor.process({.frame_index = frame,
                     .timestamp_ns = frame,
                     .name = {},
                     .left = {left.data(), kWidth, kHeight, kWidth},
                     .right = {right.data(), kWidth, kHeight, kWidth},
                     .geometry = {}});
  }
  return monitor.report();
}

TEST(SyncMonitor, SeesThatBothCamerasShowTheSameMoment) {
  const SyncReport report = watch({});
  EXPECT_EQ(report.verdict, SyncVerdict::kInStep);
  EXPECT_EQ(report.measurements, 22) << "two of them early";
  EXPECT_GE(report.matches, 20);
  EXPECT_LT(report.residual_px, 0.3);
}

TEST(SyncMonitor, SeesWhichCameraIsLate) {
  EXPECT_EQ(watch({.right_lag = 1}).verdict, SyncVerdict::kRightLate);
  EXPECT_EQ(watch({.right_lag = -1}).verdict, SyncVerdict::kRightEarly);
}

TEST(SyncMonitor, DoesNotTakeMiscalibrationForDelay) {
  const SyncReport report = watch({.misaligned_px = 2.0});
  EXPECT_NE(report.verdict, SyncVerdict::kRightLate);
  EXPECT_NE(report.verdict, SyncVerdict::kRightEarly);
  EXPECT_NEAR(report.residual_px, 2.0, 0.4);
  EXPECT_NEAR(report.signed_residual_px, 2.0, 0.4);
}

TEST(SyncMonitor, CannotTellWithoutVerticalMotion) {
  const auto still = [](int /*frame*/) { return 0.0; };
  EXPECT_EQ(watch({.nod = still}).verdict, SyncVerdict::kUnknown);
  EXPECT_EQ(watch({.nod = still, .right_lag = 1}).verdict, SyncVerdict::kUnknown);
  EXPECT_EQ(watch({.nod = still, .slide = [](int frame) { return 3.0 * frame; }, .right_lag = 1}).verdict,
            SyncVerdict::kUnknown);
}

TEST(SyncMonitor, CannotTellFromBlankImages) {
  const SyncReport report = watch({.right_lag = 1, .blank = true});
  EXPECT_EQ(report.verdict, SyncVerdict::kUnknown);
  EXPECT_EQ(report.matches, 0);
}

TEST(SyncMonitor, TellsByEvenMotionWhereFramesAreSkipped) {
  const auto slow_nod = [](int frame) { return 12.0 * std::sin(frame * 0.2); };
  for (const int kept_every : {2, 3}) {
    const auto verdict = [&](int right_lag) {
      return watch({.nod = slow_nod, .right_lag = right_lag, .kept_every = kept_every}, 80 * kept_every).verdict;
    };
    EXPECT_EQ(verdict(0), SyncVerdict::kInStep) << kept_every;
    EXPECT_EQ(verdict(1), SyncVerdict::kRightLate) << kept_every;
    EXPECT_EQ(verdict(-1), SyncVerdict::kRightEarly) << kept_every;
  }
}

TEST(SyncMonitor, CannotTellOverManyFrames) {
  const SyncReport report = watch({.right_lag = 1, .kept_every = 5}, 400);
  EXPECT_EQ(report.verdict, SyncVerdict::kUnknown);
  EXPECT_EQ(report.frames_apart, 4);
}

TEST(SyncMonitor, ChangesItsMindWhenTheCamerasDo) {
  Arena arena(SyncMonitor::required_bytes({}, kWidth, kHeight));
  SyncMonitor monitor = SyncMonitor::create({.interval_frames = 4}, kWidth, kHeight, arena).value();
  for (int frame = 0; frame < 160; ++frame) {
    const auto nod = [](int shot) { return 6.0 * std::sin(shot * 0.9); };
    const auto left = wall(0, nod(frame), false);
    const auto right = wall(24, nod(frame < 80 ? frame : frame - 1), false);
    monitor.process({.frame_index = frame,
                     .timestamp_ns = frame,
                     .name = {},
                     .left = {left.data(), kWidth, kHeight, kWidth},
                     .right = {right.data(), kWidth, kHeight, kWidth},
                     .geometry = {}});
    if (frame == 79) {
      EXPECT_EQ(monitor.report().verdict, SyncVerdict::kInStep);
    }
  }
  EXPECT_EQ(monitor.report().verdict, SyncVerdict::kRightLate);
}

TEST(SyncMonitor, SaysWhatItNeeds) {
  Arena small(SyncMonitor::required_bytes({}, kWidth, kHeight) - 1);
  EXPECT_EQ(SyncMonitor::create({}, kWidth, kHeight, small).error().code, ErrorCode::kCapacity);
  Arena arena(1 << 20);
  EXPECT_EQ(SyncMonitor::create({.interval_frames = 1}, kWidth, kHeight, arena).error().code,
            ErrorCode::kInvalidConfig);
  EXPECT_EQ(SyncMonitor::create({.max_disparity_px = 8}, kWidth, kHeight, arena).error().code,
            ErrorCode::kInvalidConfig);
  SyncMonitor tiny = SyncMonitor::create({}, 16, 16, arena).value();
  const std::vector<std::uint8_t> pixels(256, 0);
  const GrayView image{pixels.data(), 16, 16, 16};
  for (int frame = 0; frame < 20; ++frame) {
    tiny.process({frame, frame, {}, image, image, {}});
  }
  EXPECT_EQ(tiny.report().matches, 0) << "an image smaller than a patch";
}

}  // namespace
}  // namespace kinetrace::hal

// A textured wall before a rig, and all faults between it and the delivered pairs.
#include "kinetrace/hal/input_monitor.hpp"

#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "wall_for_test.hpp"

namespace kinetrace::hal {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
using Image = std::vector<std::uint8_t>;

Image wall(double right_px, double down_px) {
  return test::wall(kWidth, kHeight, right_px, down_px);
}

struct Rig {
  double disparity_px = 24.0;
  double rows_apart_px = 0.0;
  double nod_px = 6.0;
  int right_lag = 0;
  std::function<void(int frame, Image& left, Image& right)> spoil = [](int, Image&, Image&) {};
};

/// First frame of each fault; -1 for never.
struct Watched {
  std::array<int, kInputFaultCount> since{};
  [[nodiscard]] int operator[](InputFault fault) const { return since[static_cast<std::size_t>(fault)]; }
  /// All faults that were reported at some time.
  [[nodiscard]] std::vector<InputFault> faults() const {
    std::vector<InputFault> found;
    for (std::size_t i = 0; i < since.size(); ++i) {
      if (since[i] >= 0) {
        found.push_back(static_cast<InputFault>(i));
      }
    }
    return found;
  }
};

double nod(int shot, double amplitude_px = 6.0) {
  return amplitude_px * std::sin(shot * 0.9);
}

Watched watch(const Rig& rig, int frames = 40) {
  Arena arena(InputMonitor::required_bytes({}, kWidth, kHeight));
  InputMonitor monitor = InputMonitor::create({}, kWidth, kHeight, arena).value();
  Watched watched;
  watched.since.fill(-1);
  for (int frame = 0; frame < frames; ++frame) {
    Image left = wall(0.0, nod(frame, rig.nod_px));
    Image right = wall(rig.disparity_px, nod(frame - rig.right_lag, rig.nod_px) - rig.rows_apart_px);
    rig.spoil(frame, left, right);
    const GrayView left_view{left.data(), kWidth, kHeight, kWidth};
    const GrayView right_view{right.data(), kWidth, kHeight, kWidth};
    monitor.process({frame, frame, {}, left_view, right_view}, {frame, frame, {}, left_view, right_view, {}});
    for (std::size_t i = 0; i < watched.since.size(); ++i) {
      if (watched.since[i] < 0 && monitor.holds(static_cast<InputFault>(i))) {
        watched.since[i] = frame;
      }
    }
  }
  return watched;
}

using Faults = std::vector<InputFault>;

TEST(InputMonitor, FindsNothingWrongWithAGoodRig) {
  EXPECT_EQ(watch({}).faults(), Faults{});
}

// Within two seconds of 10 frames each.
TEST(InputMonitor, SeesExchangedCameras) {
  const Watched watched = watch({.disparity_px = -24.0});
  EXPECT_EQ(watched.faults(), Faults{InputFault::kViewsExchanged});
  EXPECT_LT(watched[InputFault::kViewsExchanged], 20);
}

TEST(InputMonitor, SeesThemInHalfADozenFrames) {
  EXPECT_GE(watch({.disparity_px = -24.0}, 6)[InputFault::kViewsExchanged], 0);
}

TEST(InputMonitor, SeesCamerasThatShowDifferentThings) {
  const Watched watched =
      watch({.spoil = [](int frame, const Image&, Image& right) { right = wall(10'000.0 + 500.0 * frame, 300.0); }});
  EXPECT_EQ(watched.faults(), Faults{InputFault::kViewsUnrelated});
}

TEST(InputMonitor, SeesOneImageInBothCameras) {
  const Watched watched = watch({.spoil = [](int, const Image& left, Image& right) { right = left; }});
  EXPECT_EQ(watched.faults(), (Faults{InputFault::kViewsIdentical, InputFault::kNoParallax}));
  EXPECT_EQ(watched[InputFault::kViewsIdentical], 2);
}

TEST(InputMonitor, SeesThatBothCamerasSeeTheSameThoughNotBitByBit) {
  const Watched watched = watch({.disparity_px = 0.0, .spoil = [](int frame, const Image&, Image& right) {
                                   right[static_cast<std::size_t>(frame) * 97 + 5 * kWidth + 5] ^= 1U;
                                   for (std::uint8_t& pixel : right) {
                                     pixel = static_cast<std::uint8_t>(pixel - pixel / 32);
                                   }
                                 }});
  EXPECT_EQ(watched.faults(), Faults{InputFault::kNoParallax});
}

TEST(InputMonitor, SeesACalibrationThatTurnsTheCamerasInwards) {
  // The lower half of the wall is near, the upper one far: there, half a degree of yaw exceeds the disparity.
  const Watched watched = watch({.spoil = [](int frame, const Image&, Image& right) {
    const Image far = wall(-6.0, nod(frame));
    std::copy_n(far.begin(), far.size() / 2, right.begin());
  }});
  EXPECT_EQ(watched.faults(), Faults{InputFault::kBeyondInfinity});
}

TEST(InputMonitor, SeesRowsThatAreApart) {
  const Watched watched = watch({.rows_apart_px = 4.0, .nod_px = 1.0});
  EXPECT_EQ(watched.faults(), Faults{InputFault::kRowsApart});
  EXPECT_LT(watched[InputFault::kRowsApart], 20);
}

TEST(InputMonitor, SeesACameraThatIsLate) {
  const Watched watched = watch({.right_lag = 1});
  EXPECT_EQ(watched.faults(), Faults{InputFault::kViewsOutOfStep});
  EXPECT_LT(watched[InputFault::kViewsOutOfStep], 20);
}

TEST(InputMonitor, SeesWhichCameraIsFrozen) {
  const Image still = wall(24.0, 0.0);
  EXPECT_GE(watch({.spoil = [&](int, Image&, Image& right) { right = still; }})[InputFault::kRightFrozen], 0);
  const Watched left = watch({.spoil = [&](int, Image& image, Image&) { image = still; }});
  EXPECT_EQ(left[InputFault::kLeftFrozen], 3);
  EXPECT_EQ(left[InputFault::kRightFrozen], -1);
}

TEST(InputMonitor, TakesARepeatedImageForNoFrozenOne) {
  Image kept;
  const Watched watched = watch({.spoil = [&](int frame, Image& left, Image&) {
    frame % 3 == 0 ? static_cast<void>(kept = left) : static_cast<void>(left = kept);
  }});
  EXPECT_EQ(watched[InputFault::kLeftFrozen], -1);
}

TEST(InputMonitor, ConcludesNothingFromCoveredLenses) {
  const auto cover = [](int, Image& left, Image& right) {
    left.assign(left.size(), 3);
    right = left;
  };
  EXPECT_EQ(watch({.spoil = cover}).faults(), Faults{});
}

TEST(FaultVotes, HoldOnceThreeQuartersAgree) {
  FaultVotes votes;
  EXPECT_FALSE(votes.hold());
  votes.cast(true);
  votes.cast(true);
  EXPECT_FALSE(votes.hold()) << "two are few";
  votes.cast(false);
  votes.cast(true);
  EXPECT_TRUE(votes.hold()) << "three of four";
  votes.cast(false);
  EXPECT_FALSE(votes.hold()) << "three of five";
  for (std::size_t i = 0; i < FaultVotes::kVotes; ++i) {
    votes.cast(true);
  }
  EXPECT_TRUE(votes.hold()) << "only the last ones count";
}

TEST(InputMonitor, SaysWhatItNeeds) {
  Arena small(InputMonitor::required_bytes({}, kWidth, kHeight) - 1);
  EXPECT_EQ(InputMonitor::create({}, kWidth, kHeight, small).error().code, ErrorCode::kCapacity);
}

}  // namespace
}  // namespace kinetrace::hal

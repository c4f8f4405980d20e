// USB cameras through V4L2 and through libcamera: pairing, faults and unplugging, as proved by the pixels.
#include <algorithm>
#include <cstdlib>
#include <fcntl.h>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "backends.hpp"
#include "capture.hpp"
#include "capture/v4l2/v4l2_node.hpp"
#include "live_bench.hpp"
#include "util/owned_fd.hpp"
#include "uvc/uvc_pair.hpp"

namespace kinetrace::hal::test {
namespace {

constexpr int kVeryMany = 300;

class Uvc : public ::testing::TestWithParam<CaptureBackend> {
 protected:
  void SetUp() override {
    if (GetParam() == CaptureBackend::kLibcamera) {
      use_all_backends();
    }
    UvcPair::wait_until_listed(GetParam(), 2);
  }
  [[nodiscard]] CaptureConfig config(int view, PixelFormat format = PixelFormat::kGrey8) const {
    return pair_.config(GetParam(), view, format);
  }
  [[nodiscard]] LiveCameraConfig stereo(PixelFormat format = PixelFormat::kGrey8) const {
    return live_config(config(0, format), config(1, format));
  }
  UvcPair& pair_ = UvcPair::instance();
};

FrameMark mark_of(const Picture& picture) {
  return read_mark({picture.pixels.data(), picture.width, picture.height, picture.width}).value_or(FrameMark{0, -1});
}

/// The camera's current device file.
std::string path_of(const SimulatedUvcCamera& camera) {
  const auto node = find_v4l2_node(camera.bus_id());
  return node ? node->path : node.error().message;
}

/// Checks frames of a camera: each later than the one before, each with two cameras of one moment.
class PairChecker {
 public:
  explicit PairChecker(StereoCamera& camera) : camera_(camera) {}

  Result<StereoFrame> next() {
    Result<StereoFrame> frame = camera_.next(kMaxLateFrames);
    if (frame) {
      const auto left = read_mark(frame->left);
      const auto right = read_mark(frame->right);
      EXPECT_TRUE(left && right) << "the picture is not what the camera sent";
      if (left && right) {
        EXPECT_EQ(left->view, 0);
        EXPECT_EQ(right->view, 1);
        EXPECT_EQ(left->index, right->index) << "left and right are of different moments";
        EXPECT_GT(left->index, index_);
        index_ = left->index;
      }
      EXPECT_GT(frame->frame_index, frame_index_);
      EXPECT_GT(frame->timestamp_ns, time_ns_);
      frame_index_ = frame->frame_index;
      time_ns_ = frame->timestamp_ns;
    }
    return frame;
  }
  void expect_pairs(int count) {
    for (int i = 0; i < count; ++i) {
      const auto frame = next();
      ASSERT_TRUE(frame) << frame.error().message;
    }
  }
  Error last_error() {
    for (int i = 0; i < kVeryMany; ++i) {
      if (const auto frame = next(); !frame) {
        return frame.error();
      }
    }
    return {ErrorCode::kInternal, "the stream continues"};
  }
  /// Recovers, in as many attempts as needed.
  [[nodiscard]] bool recovers() {
    for (int i = 0; i < kVeryMany; ++i) {
      if (camera_.recover()) {
        return true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  }
  /// Result of the first attempt to recover that was due.
  [[nodiscard]] std::string recovery_error() {
    for (int i = 0; i < kVeryMany; ++i) {
      const Status back = camera_.recover();
      if (back || back.error().message.find("not yet due") == std::string::npos) {
        return back ? "it is back" : back.error().message;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return "no attempt was made";
  }
  [[nodiscard]] std::uint32_t index() const { return index_; }

 private:
  StereoCamera& camera_;
  std::uint32_t index_ = 0;
  std::int64_t frame_index_ = -1;
  std::int64_t time_ns_ = -1;
};

TEST_P(Uvc, EveryFormatCarriesThePicture) {
  for (const PixelFormat format : {PixelFormat::kGrey8, PixelFormat::kYuyv, PixelFormat::kMjpeg}) {
    for (const int view : {0, 1}) {
      SCOPED_TRACE(std::string(to_string(format)) + " camera " + std::to_string(view));
      const CaptureConfig wanted = config(view, format);
      const Picture picture = take_picture(*make_streaming(wanted), wanted);
      EXPECT_EQ(picture.width, 320);
      EXPECT_EQ(picture.height, 240);
      EXPECT_EQ(mark_of(picture).view, view);
    }
  }
}

TEST_P(Uvc, SequencesOfUsbCamerasDoNotCountLosses) {
  const auto device = make_streaming(config(0));
  EXPECT_FALSE(device->info().sequence_counts_losses);
  EXPECT_EQ(device->info().timestamp_kind, TimestampKind::kStartOfExposure);
}

TEST_P(Uvc, PairsAreOfOneMoment) {
  LiveBench bench(stereo());
  ASSERT_TRUE(bench.camera().open());
  ASSERT_TRUE(bench.camera().start());
  PairChecker(bench.camera()).expect_pairs(12);
}

TEST_P(Uvc, CompressedPairsAreOfOneMomentAndACutImageIsSkipped) {
  LiveBench bench(stereo(PixelFormat::kMjpeg));
  ASSERT_TRUE(bench.camera().open());
  ASSERT_TRUE(bench.camera().start());
  PairChecker checker(bench.camera());
  checker.expect_pairs(3);
  pair_.right.cut_frames(2);
  for (int i = 0; i < kVeryMany && bench.camera().counters().skipped_unreadable == 0; ++i) {
    checker.expect_pairs(1);
  }
  EXPECT_GT(bench.camera().counters().skipped_unreadable, 0U);
  checker.expect_pairs(3);
}

TEST_P(Uvc, FramesThatTheSensorLosesCostTheirPartnersOnly) {
  LiveBench bench(stereo());
  ASSERT_TRUE(bench.camera().open());
  ASSERT_TRUE(bench.camera().start());
  PairChecker checker(bench.camera());
  checker.expect_pairs(3);
  pair_.left.drop_frames(1);
  for (int i = 0; i < kVeryMany && bench.camera().counters().skipped_missing_side == 0; ++i) {
    checker.expect_pairs(1);
  }
  EXPECT_GT(bench.camera().counters().skipped_missing_side, 0U);
  checker.expect_pairs(3);
}

TEST_P(Uvc, FramesThatBothSensorsLoseAreGapsThoughTheDriverCountsNone) {
  LiveBench bench(stereo());
  ASSERT_TRUE(bench.camera().open());
  ASSERT_TRUE(bench.camera().start());
  PairChecker checker(bench.camera());
  checker.expect_pairs(3);
  // Enough that both cameras drop some frames in common.
  constexpr int kSeveral = 3;
  pair_.left.drop_frames(kSeveral);
  pair_.right.drop_frames(kSeveral);
  for (int i = 0; i < kVeryMany && bench.camera().counters().gaps == 0; ++i) {
    checker.expect_pairs(1);
  }
  EXPECT_GT(bench.camera().counters().gaps, 0U);
  checker.expect_pairs(3);
}

TEST_P(Uvc, OneDeviceWithBothCamerasIsSplitWithoutACopy) {
  CaptureConfig both = config(0);
  both.width_px = 640;
  LiveBench bench(live_config(both, std::nullopt));
  ASSERT_TRUE(bench.camera().open());
  EXPECT_EQ(bench.camera().info().width_px, 320);
  ASSERT_TRUE(bench.camera().start());
  PairChecker checker(bench.camera());
  checker.expect_pairs(3);
  const auto frame = checker.next();
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->right.data - frame->left.data, 320) << "both views lie in the device's own buffer";
  EXPECT_GE(frame->left.stride, 640);
}

TEST_P(Uvc, ExposureAndGainReachTheSensor) {
  CaptureConfig dark = config(0);
  dark.exposure_us = 3000.0;
  if (GetParam() == CaptureBackend::kV4l2) {
    dark.gain = 32.0;
  }
  CaptureConfig bright = dark;
  bright.exposure_us = 12'000.0;
  int previous = 0;
  for (const CaptureConfig& wanted : {dark, bright}) {
    const auto device = make_streaming(wanted);
    EXPECT_EQ(device->info().exposure_us, wanted.exposure_us);
    EXPECT_EQ(device->info().gain, wanted.gain);
    // A control reaches the sensor some frames later.
    Picture picture;
    for (int i = 0; i < 8; ++i) {
      picture = take_picture(*device, wanted);
    }
    const int brightest =
        *std::max_element(picture.pixels.begin() + std::ptrdiff_t{20} * picture.width, picture.pixels.end());
    EXPECT_GT(brightest, 2 * previous);
    EXPECT_LT(brightest, 250);
    previous = brightest;
  }
}

TEST_P(Uvc, AnExposureItCannotSetIsAnErrorThatPrintsBoth) {
  CaptureConfig endless = config(0);
  endless.exposure_us = 9e6;
  const Status opened = make_device(endless)->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(opened.error().message,
              ::testing::AllOf(::testing::HasSubstr("asked for exposure_us 9e+06"), ::testing::HasSubstr("1e+06")));
}

TEST_P(Uvc, AModeItLacksIsAnErrorThatPrintsBoth) {
  CaptureConfig wrong = config(0);
  wrong.width_px = 700;
  const Status opened = make_device(wrong)->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(opened.error().message,
              ::testing::AllOf(::testing::HasSubstr("700x240"), ::testing::ContainsRegex(" set [^;]*640x240")));
}

TEST_P(Uvc, ASecondUserLearnsThatItIsBusy) {
  const auto first = make_streaming(config(0));
  const auto second = make_device(config(0));
  const Status opened = second->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kIo);
  EXPECT_THAT(opened.error().message, ::testing::HasSubstr("in use by another program"));
}

TEST_P(Uvc, AStallIsATimeoutAndEnds) {
  const auto device = make_streaming(config(0));
  ASSERT_TRUE(device->next(kMaxLateFrames));
  pair_.left.set_stalled(true);
  Error error{ErrorCode::kInternal, {}};
  for (int i = 0; i < kVeryMany && error.code == ErrorCode::kInternal; ++i) {
    const auto image = device->next(std::chrono::milliseconds(500));
    if (image) {
      device->release(image->slot);
    } else {
      error = image.error();
    }
  }
  EXPECT_EQ(error.code, ErrorCode::kTimeout);
  pair_.left.set_stalled(false);
  EXPECT_TRUE(device->next(kMaxLateFrames));
}

TEST_P(Uvc, AStalledCameraEndsPairsUntilItComesBack) {
  LiveBench bench(stereo());
  ASSERT_TRUE(bench.camera().open());
  ASSERT_TRUE(bench.camera().start());
  PairChecker checker(bench.camera());
  checker.expect_pairs(3);
  pair_.right.set_stalled(true);
  const Error error = checker.last_error();
  EXPECT_EQ(error.code, ErrorCode::kDisconnected);
  EXPECT_THAT(error.message, ::testing::HasSubstr("right camera"));
  EXPECT_EQ(bench.camera().state(), CameraState::kLost);
  pair_.right.set_stalled(false);
  ASSERT_TRUE(checker.recovers());
  checker.expect_pairs(3);
}

TEST_P(Uvc, AnUnpluggedCameraIsLostAtOnceAndTakenBackWhenItReturns) {
  LiveBench bench(stereo());
  ASSERT_TRUE(bench.camera().open());
  ASSERT_TRUE(bench.camera().start());
  PairChecker checker(bench.camera());
  checker.expect_pairs(3);
  // An open descriptor keeps the old device file, so that the camera comes back under another number.
  const std::string path = path_of(pair_.right);
  const OwnedFd kept(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  pair_.right.unplug();
  const Error error = checker.last_error();
  EXPECT_EQ(error.code, ErrorCode::kDisconnected);
  EXPECT_THAT(error.message, ::testing::HasSubstr("right camera"));
  EXPECT_EQ(bench.camera().state(), CameraState::kLost);
  UvcPair::wait_until_listed(GetParam(), 1);
  EXPECT_THAT(checker.recovery_error(), ::testing::HasSubstr("there are: "));
  pair_.right.plug();
  ASSERT_TRUE(checker.recovers());
  checker.expect_pairs(3);
  EXPECT_NE(path_of(pair_.right), path);
  EXPECT_EQ(bench.camera().counters().losses, 1U);
  EXPECT_EQ(bench.camera().counters().recoveries, 1U);
}

INSTANTIATE_TEST_SUITE_P(V4l2, Uvc, ::testing::Values(CaptureBackend::kV4l2));
INSTANTIATE_TEST_SUITE_P(Libcamera, Uvc, ::testing::Values(CaptureBackend::kLibcamera));

class UvcUnplugging : public Uvc {};

// KINETRACE_VM_ROUNDS raises the number.
int rounds() {
  constexpr int kFew = 2;
  const char* asked = std::getenv("KINETRACE_VM_ROUNDS");
  return asked != nullptr ? std::atoi(asked) : kFew;
}

TEST_P(UvcUnplugging, ACameraIsUnpluggedAgainAndAgain) {
  LiveBench bench(stereo());
  ASSERT_TRUE(bench.camera().open());
  ASSERT_TRUE(bench.camera().start());
  PairChecker checker(bench.camera());
  for (int round = 0; round < rounds(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    SimulatedUvcCamera& view = round % 2 == 0 ? pair_.right : pair_.left;
    checker.expect_pairs(1 + round % 3);
    view.unplug();
    ASSERT_EQ(checker.last_error().code, ErrorCode::kDisconnected);
    view.plug();
    ASSERT_TRUE(checker.recovers());
  }
  checker.expect_pairs(3);
  EXPECT_EQ(bench.camera().counters().recoveries, static_cast<std::uint64_t>(rounds()));
}

// As with cameras that share a hub or a cable.
TEST_P(UvcUnplugging, BothCamerasAreUnpluggedAgainAndAgain) {
  LiveBench bench(stereo());
  ASSERT_TRUE(bench.camera().open());
  ASSERT_TRUE(bench.camera().start());
  PairChecker checker(bench.camera());
  for (int round = 0; round < rounds(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    checker.expect_pairs(1);
    std::thread other([this] { pair_.left.unplug(); });
    pair_.right.unplug();
    other.join();
    ASSERT_EQ(checker.last_error().code, ErrorCode::kDisconnected);
    pair_.left.plug();
    pair_.right.plug();
    ASSERT_TRUE(checker.recovers());
  }
  checker.expect_pairs(3);
}

// No call has noticed the unplugging yet.
TEST_P(UvcUnplugging, ClosingRacesWithUnplugging) {
  for (int round = 0; round < rounds(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    UvcPair::wait_until_listed(GetParam(), 2);
    LiveBench bench(stereo());
    ASSERT_TRUE(bench.camera().open());
    ASSERT_TRUE(bench.camera().start());
    PairChecker(bench.camera()).expect_pairs(1);
    std::thread unplugging([this] { pair_.right.unplug(); });
    std::this_thread::sleep_for(std::chrono::milliseconds(3 * (round % 8)));
    bench.camera().close();
    unplugging.join();
    pair_.right.plug();
  }
  UvcPair::wait_until_listed(GetParam(), 2);
}

INSTANTIATE_TEST_SUITE_P(V4l2, UvcUnplugging, ::testing::Values(CaptureBackend::kV4l2));
INSTANTIATE_TEST_SUITE_P(Libcamera, UvcUnplugging, ::testing::Values(CaptureBackend::kLibcamera));

TEST(UvcV4l2, ASerialNumberFindsItsCamera) {
  UvcPair& pair = UvcPair::instance();
  UvcPair::wait_until_listed(CaptureBackend::kV4l2, 2);
  for (SimulatedUvcCamera* camera : {&pair.left, &pair.right}) {
    CaptureConfig config = pair.config(CaptureBackend::kV4l2, 0);
    config.device = camera->serial();
    auto device = make_device(config);
    const Status opened = device->open();
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_EQ(device->info().stable_id, camera->bus_id());
    EXPECT_EQ(device->info().serial, camera->serial());
  }
}

TEST(UvcV4l2, ImagesTellTheExposureThatAutomaticsChose) {
  const UvcPair& pair = UvcPair::instance();
  UvcPair::wait_until_listed(CaptureBackend::kV4l2, 2);
  // The simulated automatic exposure keeps the earlier value.
  CaptureConfig config = pair.config(CaptureBackend::kV4l2, 0);
  config.exposure_us = 7000.0;
  make_streaming(config)->close();
  config.exposure_us.reset();
  const auto device = make_streaming(config);
  const auto image = device->next(kMaxLateFrames);
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_EQ(image->exposure_ns, 7'000'000);
}

}  // namespace
}  // namespace kinetrace::hal::test

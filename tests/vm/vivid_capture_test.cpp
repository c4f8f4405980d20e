// The V4L2 backend on the kernel's test driver: two cameras, every format, and every fault that driver can inject.
#include <cmath>
#include <cstring>
#include <linux/videodev2.h>
#include <set>
#include <sys/mman.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture.hpp"
#include "capture/v4l2/v4l2_file.hpp"
#include "capture/v4l2/v4l2_node.hpp"
#include "vivid.hpp"

namespace kinetrace::hal::test {
namespace {

using std::chrono::milliseconds;
using ::testing::AllOf;
using ::testing::HasSubstr;

class Vivid : public ::testing::Test {
 protected:
  VividControls controls_{kVividLeft};
  CaptureConfig config_ = vivid_config(kVividLeft);
};

/// Takes images until one is `wanted`, and returns all buffers; false after very many.
template <typename Wanted>
bool comes(CaptureDevice& device, Wanted wanted) {
  constexpr int kVeryMany = 300;
  for (int i = 0; i < kVeryMany; ++i) {
    const auto image = device.next(kMaxLateFrames);
    if (!image) {
      ADD_FAILURE() << image.error().message;
      return false;
    }
    const bool found = wanted(*image);
    device.release(image->slot);
    if (found) {
      return true;
    }
  }
  return false;
}

bool is_sound(const CapturedImage& image) {
  return !image.damaged;
}

/// Luminance of limited range, as video formats carry it.
int video_level(int full) {
  return 16 + (full * 219 + 127) / 255;
}

/// The error that ends a stream; buffers before it are returned.
Error last_error(CaptureDevice& device, milliseconds timeouts = kMaxLateFrames) {
  constexpr int kVeryMany = 300;
  for (int i = 0; i < kVeryMany; ++i) {
    const auto image = device.next(timeouts);
    if (!image) {
      return image.error();
    }
    device.release(image->slot);
  }
  return {ErrorCode::kInternal, "the stream continues"};
}

TEST_F(Vivid, TwoCamerasStreamAtOnceAndInOrder) {
  const auto left = make_streaming(vivid_config(kVividLeft));
  const auto right = make_streaming(vivid_config(kVividRight));
  std::array<std::int64_t, 2> sequence{-1, -1};
  std::array<std::int64_t, 2> time_ns{};
  for (int i = 0; i < 10; ++i) {
    for (std::size_t view = 0; view < 2; ++view) {
      CaptureDevice& device = view == 0 ? *left : *right;
      const auto image = device.next(kMaxLateFrames);
      ASSERT_TRUE(image) << image.error().message;
      EXPECT_FALSE(image->damaged);
      EXPECT_GT(image->sequence, sequence[view]);
      EXPECT_GT(image->timestamp_ns, time_ns[view]);
      sequence[view] = image->sequence;
      time_ns[view] = image->timestamp_ns;
      device.release(image->slot);
    }
  }
}

TEST_F(Vivid, IsFoundByPathBusIdAndStableId) {
  for (const std::string& name : {std::string("/dev/video0"), kVividLeft}) {
    auto device = make_device(vivid_config(name));
    ASSERT_TRUE(device->open()) << name;
    EXPECT_EQ(device->info().stable_id, kVividLeft);
    EXPECT_THAT(device->info().name, HasSubstr(kVividLeft));
  }
}

TEST_F(Vivid, NamesWhatThereIsWhereADeviceIsNotFound) {
  for (const std::string name : {"/dev/video9", "usb-nowhere-1"}) {
    const Status opened = make_device(vivid_config(name))->open();
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().code, ErrorCode::kNotFound);
    EXPECT_THAT(opened.error().message, AllOf(HasSubstr(name), HasSubstr("/dev/video0 = " + kVividLeft)));
  }
}

TEST_F(Vivid, AFileThatIsNoCameraIsRefused) {
  const Status opened = make_device(vivid_config("/dev/null"))->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kUnsupported);
}

TEST_F(Vivid, ListsItsModes) {
  const std::vector<CaptureListing> listings = list_capture_devices();
  ASSERT_EQ(listings.size(), 2U);
  EXPECT_EQ(listings[0].path, "/dev/video0");
  EXPECT_EQ(listings[0].stable_id, kVividLeft);
  EXPECT_EQ(listings[1].stable_id, kVividRight);
  for (const CaptureListing& listing : listings) {
    EXPECT_THAT(listing.modes, ::testing::Contains(AllOf(HasSubstr("grey8 320x180 at "), HasSubstr("30"))));
    EXPECT_THAT(listing.modes, ::testing::Contains(HasSubstr("nv12 320x180 ")).Times(1));
  }
}

// The same ramp must come out of every format and of both programming interfaces; the multi-planar device has NV12 in
// two planes.
TEST_F(Vivid, EveryFormatShowsTheSamePicture) {
  constexpr int kGrayRamp = 20;
  const VividControls right_controls(kVividRight);
  controls_.set("Test Pattern", kGrayRamp);
  right_controls.set("Test Pattern", kGrayRamp);
  const Picture grey = take_picture(*make_streaming(config_), config_);
  ASSERT_EQ(grey.width, config_.width_px);
  ASSERT_EQ(grey.height, config_.height_px);
  const std::set<std::uint8_t> levels(grey.pixels.begin(), grey.pixels.end());
  ASSERT_GE(levels.size(), 50U) << "a picture of one value would prove nothing";
  for (const std::string& device : {kVividLeft, kVividRight}) {
    for (const PixelFormat format :
         {PixelFormat::kGrey8, PixelFormat::kGrey10, PixelFormat::kGrey16, PixelFormat::kYuyv, PixelFormat::kNv12}) {
      SCOPED_TRACE(device + " " + std::string(to_string(format)));
      const CaptureConfig config = vivid_config(device, format);
      const Picture picture = take_picture(*make_streaming(config), config);
      ASSERT_EQ(picture.pixels.size(), grey.pixels.size());
      const bool is_video = format == PixelFormat::kYuyv || format == PixelFormat::kNv12;
      int worst = 0;
      for (std::size_t i = 0; i < grey.pixels.size(); ++i) {
        const int expected = is_video ? video_level(grey.pixels[i]) : grey.pixels[i];
        worst = std::max(worst, std::abs(expected - picture.pixels[i]));
      }
      EXPECT_LE(worst, 2);
    }
  }
}

TEST_F(Vivid, NV12InTwoPlanesIsTakenWhereTheDeviceHasIt) {
  const auto device = make_streaming(vivid_config(kVividRight, PixelFormat::kNv12));
  const auto file = V4l2File::open(find_v4l2_node(kVividRight)->path);
  ASSERT_TRUE(file);
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
  ASSERT_EQ(file->call(VIDIOC_G_FMT, &format), 0);
  EXPECT_EQ(format.fmt.pix_mp.num_planes, 2);
  const auto image = device->next(kMaxLateFrames);
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_FALSE(image->damaged);
  EXPECT_EQ(image->data.size(), format.fmt.pix_mp.plane_fmt[0].sizeimage) << "luminance alone";
}

TEST_F(Vivid, ExportsItsBuffers) {
  const auto device = make_streaming(config_);
  const auto image = device->next(kMaxLateFrames);
  ASSERT_TRUE(image) << image.error().message;
  ASSERT_TRUE(image->dmabuf_fd);
  const std::size_t length = image->data.size();
  void* const other = mmap(nullptr, length, PROT_READ, MAP_SHARED, *image->dmabuf_fd, 0);
  ASSERT_NE(other, MAP_FAILED);
  EXPECT_EQ(std::memcmp(other, image->data.data(), length), 0);
  munmap(other, length);
}

TEST_F(Vivid, TellsWhichMomentIsStamped) {
  for (const auto& [source, kind] : {std::pair{0, TimestampKind::kEndOfExposure},  //
                                     std::pair{1, TimestampKind::kStartOfExposure}}) {
    controls_.set("Timestamp Source", source);
    auto device = make_device(config_);
    ASSERT_TRUE(device->open());
    EXPECT_EQ(device->info().timestamp_kind, kind);
  }
}

TEST_F(Vivid, WhatTheDriverDoesNotSetIsAnErrorThatPrintsBoth) {
  struct Case {
    CaptureConfig config;
    std::string asked;
    std::string set;
  };
  CaptureConfig wrong_size = config_;
  wrong_size.width_px = 700;
  wrong_size.height_px = 500;
  CaptureConfig wrong_format = config_;
  wrong_format.format = PixelFormat::kMjpeg;
  CaptureConfig wrong_rate = config_;
  wrong_rate.rate_hz = 33.0;
  CaptureConfig wrong_gain = config_;
  wrong_gain.gain = 1e5;
  for (const Case& wrong : {Case{wrong_size, "asked for GREY 700x500", "the driver set GREY 640x480"},
                            Case{wrong_format, "asked for MJPG 320x180", "the driver set "},
                            Case{wrong_rate, "asked for 33 Hz", "the driver set 40 Hz"},
                            Case{wrong_gain, "asked for gain 100000", "the driver set 255"}}) {
    const Status opened = make_device(wrong.config)->open();
    ASSERT_FALSE(opened) << wrong.asked;
    EXPECT_EQ(opened.error().code, ErrorCode::kUnsupported);
    EXPECT_THAT(opened.error().message, AllOf(HasSubstr(wrong.asked), HasSubstr(wrong.set), HasSubstr("it can: ")));
  }
}

TEST_F(Vivid, ControlsThatItLacksAreErrors) {
  CaptureConfig exposure = config_;
  exposure.exposure_us = 5000.0;
  CaptureConfig trigger = config_;
  trigger.trigger = TriggerMode::kExternal;
  for (const CaptureConfig& config : {exposure, trigger}) {
    const Status opened = make_device(config)->open();
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().code, ErrorCode::kUnsupported);
  }
}

TEST_F(Vivid, GainIsReadBack) {
  config_.gain = 77.0;
  auto device = make_device(config_);
  ASSERT_TRUE(device->open());
  EXPECT_EQ(device->info().gain, 77.0);
}

TEST_F(Vivid, ASecondUserLearnsThatItIsBusy) {
  const auto first = make_streaming(config_);
  CaptureConfig other = config_;
  other.width_px = 640;
  other.height_px = 360;
  const Status opened = make_device(other)->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kIo);
  EXPECT_THAT(opened.error().message, HasSubstr("in use by another program"));
  EXPECT_TRUE(comes(*first, is_sound)) << "the first user must not notice";
}

TEST_F(Vivid, DroppedFramesAreGapsInTheSequence) {
  controls_.set("Percentage of Dropped Buffers", 50);
  const auto device = make_streaming(config_);
  EXPECT_TRUE(device->info().sequence_counts_losses);
  std::int64_t previous = -1;
  EXPECT_TRUE(comes(*device, [&previous](const CapturedImage& image) {
    const bool is_gap = previous >= 0 && image.sequence > previous + 1;
    EXPECT_GT(image.sequence, previous);
    previous = image.sequence;
    return is_gap;
  }));
}

TEST_F(Vivid, AStuckStreamIsATimeoutAndMayContinue) {
  const auto device = make_streaming(config_);
  ASSERT_TRUE(comes(*device, is_sound));
  controls_.set("Percentage of Dropped Buffers", 100);
  EXPECT_EQ(last_error(*device, milliseconds(500)).code, ErrorCode::kTimeout);
  controls_.set("Percentage of Dropped Buffers", 0);
  EXPECT_TRUE(comes(*device, is_sound));
}

TEST_F(Vivid, AFlaggedBufferIsDamagedAndTheNextIsNot) {
  const auto device = make_streaming(config_);
  ASSERT_TRUE(comes(*device, is_sound));
  controls_.set("Inject V4L2_BUF_FLAG_ERROR", 1);
  EXPECT_TRUE(comes(*device, [](const CapturedImage& image) { return image.damaged; }));
  EXPECT_TRUE(comes(*device, is_sound));
}

TEST_F(Vivid, RefusedBuffersFailTheOpeningAloneOnce) {
  controls_.set("Inject VIDIOC_REQBUFS Error", 1);
  auto device = make_device(config_);
  const Status opened = device->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kIo);
  EXPECT_THAT(opened.error().message, HasSubstr("requesting buffers"));
  ASSERT_TRUE(device->open());
  ASSERT_TRUE(device->start());
  EXPECT_TRUE(comes(*device, is_sound));
}

TEST_F(Vivid, ABufferThatTheDriverRefusesIsOfferedAgain) {
  const auto device = make_streaming(config_);
  auto image = device->next(kMaxLateFrames);
  ASSERT_TRUE(image);
  const int refused = image->slot;
  controls_.set("Inject VIDIOC_QBUF Error", 1);
  device->release(refused);
  EXPECT_TRUE(comes(*device, [refused](const CapturedImage& later) { return later.slot == refused; }));
}

TEST_F(Vivid, ARefusedStartCanBeRepeated) {
  auto device = make_device(config_);
  ASSERT_TRUE(device->open());
  controls_.set("Inject VIDIOC_STREAMON Error", 1);
  const Status started = device->start();
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().code, ErrorCode::kIo);
  ASSERT_TRUE(device->start());
  EXPECT_TRUE(comes(*device, is_sound));
}

TEST_F(Vivid, AFatalErrorEndsTheStreamUntilItIsStartedAgain) {
  const auto device = make_streaming(config_);
  ASSERT_TRUE(comes(*device, is_sound));
  controls_.set("Inject Fatal Streaming Error", 1);
  EXPECT_EQ(last_error(*device).code, ErrorCode::kIo);
  ASSERT_TRUE(device->stop());
  ASSERT_TRUE(device->start());
  EXPECT_TRUE(comes(*device, is_sound));
}

TEST_F(Vivid, ADisconnectedDeviceSaysSoAndCanBeTakenBack) {
  auto device = make_streaming(config_);
  ASSERT_TRUE(comes(*device, is_sound));
  controls_.set("Disconnect", 1);
  EXPECT_EQ(last_error(*device).code, ErrorCode::kDisconnected);
  EXPECT_TRUE(device->stop());
  device->close();
}

TEST_F(Vivid, SequenceContinuesWhereTheDriversWraps) {
  controls_.set("Wrap Sequence Number", 1);
  config_.rate_hz = 60.0;
  const auto device = make_streaming(config_);
  constexpr std::int64_t kWrap = std::int64_t{1} << 32;
  std::int64_t previous = -1;
  EXPECT_TRUE(comes(*device, [&previous](const CapturedImage& image) {
    EXPECT_GE(image.sequence, previous) << "on a late tick vivid numbers two frames alike, but never goes back";
    previous = image.sequence;
    return image.sequence > kWrap;
  }));
}

TEST_F(Vivid, ImagesThatAreKeptCostNewOnesAndNothingElse) {
  const auto device = make_streaming(config_);
  std::vector<int> kept;
  for (int i = 0; i < config_.buffers; ++i) {
    const auto image = device->next(kMaxLateFrames);
    ASSERT_TRUE(image) << image.error().message;
    kept.push_back(image->slot);
  }
  EXPECT_EQ(std::set<int>(kept.begin(), kept.end()).size(), kept.size());
  EXPECT_EQ(device->next(milliseconds(300)).error().code, ErrorCode::kTimeout);
  for (const int slot : kept) {
    device->release(slot);
  }
  EXPECT_TRUE(comes(*device, is_sound));
}

TEST_F(Vivid, ReleasingWhatIsNotOutIsHarmless) {
  const auto device = make_streaming(config_);
  for (const int slot : {-1, 0, 1, 1000}) {
    device->release(slot);
  }
  EXPECT_TRUE(comes(*device, is_sound));
  ASSERT_TRUE(device->stop());
  device->release(0);
  ASSERT_TRUE(device->start());
  EXPECT_TRUE(comes(*device, is_sound));
}

}  // namespace
}  // namespace kinetrace::hal::test

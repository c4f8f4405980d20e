// Cameras in separate processes: images arrive without a copy, and a library's crash costs only the camera.
#include "capture/isolated/isolated_backend.hpp"

#include <algorithm>
#include <array>
#include <csignal>
#include <memory>
#include <string>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <unistd.h>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "util/owned_fd.hpp"

namespace kinetrace::hal {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kImageBytes = 64;
constexpr std::size_t kBufferBytes = 4096;
constexpr std::chrono::milliseconds kTimeout{5000};

/// A library whose device delivers as fast as buffers come back, and dies at the moment given by its name.
class BrittleDevice final : public CaptureDevice {
 public:
  explicit BrittleDevice(CaptureConfig config) : config_(std::move(config)) {
    for (OwnedFd& buffer : buffers_) {
      buffer = OwnedFd(memfd_create("buffer", MFD_CLOEXEC));
      [[maybe_unused]] const int grown = ftruncate(buffer.get(), kBufferBytes);
    }
  }
  Status open() override {
    if (config_.device == "absent") {
      return fail(ErrorCode::kNotFound, "absent: there is no such camera");
    }
    die_if("dies opening");
    info_.name = config_.device + " (fake)";
    info_.stride_bytes = config_.width_px;
    return {};
  }
  Status start() override {
    die_if("dies starting");
    busy_ = {};
    raise_level();
    return {};
  }
  Result<CapturedImage> next(std::chrono::milliseconds /*timeout*/) override {
    const auto free = std::find(busy_.begin(), busy_.end(), false);
    if (free == busy_.end()) {
      std::uint64_t count = 0;
      [[maybe_unused]] const ssize_t got = read(level_.get(), &count, sizeof count);
      return fail(ErrorCode::kTimeout, "no image");
    }
    if (sequence_ == 3 && config_.device == "is unplugged") {
      return fail(ErrorCode::kDisconnected, "is unplugged: the device has gone");
    }
    if (sequence_ == 3) {
      die_if("dies streaming");
    }
    *free = true;
    const auto slot = static_cast<int>(free - busy_.begin());
    std::array<std::byte, kImageBytes> pixels{};
    pixels.fill(static_cast<std::byte>(sequence_));
    const int buffer = buffers_[static_cast<std::size_t>(slot)].get();
    [[maybe_unused]] const ssize_t put = pwrite(buffer, pixels.data(), pixels.size(), kOffset);
    CapturedImage image{.slot = slot, .sequence = sequence_++, .timestamp_ns = 7, .data = pixels_};
    image.dmabuf_fd = buffer;
    image.dmabuf_offset_bytes = kOffset;
    return image;
  }
  void release(int slot) noexcept override {
    busy_[static_cast<std::size_t>(slot)] = false;
    raise_level();
  }
  Status stop() override { return {}; }
  void close() noexcept override {}
  int wait_fd() const noexcept override { return level_.get(); }
  const CaptureInfo& info() const noexcept override { return info_; }

  static constexpr int kOffset = 16;

 private:
  void die_if(const char* moment) const {
    if (config_.device == moment) {
      raise(SIGKILL);  // As a crash looks to other processes, without core file or report.
    }
  }
  void raise_level() const {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t put = write(level_.get(), &one, sizeof one);
  }

  CaptureConfig config_;
  CaptureInfo info_;
  OwnedFd level_{eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)};
  std::array<OwnedFd, 4> buffers_;
  std::array<bool, 4> busy_{};
  std::array<std::byte, kImageBytes> pixels_{};
  std::int64_t sequence_ = 0;
};

CaptureBackendEntry brittle() {
  return isolate({[](const CaptureConfig& config) -> std::unique_ptr<CaptureDevice> {
                    return std::make_unique<BrittleDevice>(config);
                  },
                  [] {
                    CaptureListing listing;
                    listing.stable_id = std::to_string(getpid());
                    listing.name = "fake";
                    listing.modes = {"one", "two"};
                    return std::vector{listing};
                  }},
                 "brittle");
}

std::unique_ptr<CaptureDevice> device_of(const CaptureBackendEntry& backend, const std::string& name) {
  CaptureConfig config;
  config.device = name;
  config.width_px = 8;
  return backend.make(config);
}

/// The error that ends a stream.
Error last_error(CaptureDevice& device) {
  constexpr int kMany = 100;
  for (int i = 0; i < kMany; ++i) {
    const auto image = device.next(kTimeout);
    if (!image) {
      return image.error();
    }
    device.release(image->slot);
  }
  return {ErrorCode::kInternal, "the stream continues"};
}

TEST(IsolatedBackend, ListsFromAnotherProcess) {
  const auto listings = brittle().list();
  ASSERT_EQ(listings.size(), 1U);
  EXPECT_EQ(listings[0].name, "fake");
  EXPECT_NE(listings[0].stable_id, std::to_string(getpid()));
  EXPECT_THAT(listings[0].modes, ::testing::ElementsAre("one", "two"));
}

TEST(IsolatedBackend, ImagesArriveInOrderAndBuffersGoBack) {
  const auto device = device_of(brittle(), "sound");
  ASSERT_TRUE(device->open());
  EXPECT_EQ(device->info().name, "sound (fake)");
  EXPECT_EQ(device->info().stride_bytes, 8);
  ASSERT_TRUE(device->start());
  for (int i = 0; i < 40; ++i) {
    const auto image = device->next(kTimeout);
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_EQ(image->sequence, i);
    EXPECT_FALSE(image->damaged);
    ASSERT_EQ(image->data.size(), kImageBytes);
    EXPECT_EQ(image->data.front(), static_cast<std::byte>(i));
    EXPECT_EQ(image->data.back(), static_cast<std::byte>(i));
    device->release(image->slot);
  }
}

TEST(IsolatedBackend, AStreamStartedAgainForgetsTheOneBefore) {
  const auto device = device_of(brittle(), "sound");
  ASSERT_TRUE(device->open());
  ASSERT_TRUE(device->start());
  const auto held = device->next(kTimeout);
  ASSERT_TRUE(held);
  ASSERT_TRUE(device->stop());
  device->release(held->slot);
  ASSERT_TRUE(device->start());
  const auto image = device->next(kTimeout);
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_GT(image->sequence, held->sequence);
  EXPECT_FALSE(image->damaged);
}

TEST(IsolatedBackend, ErrorsOfTheDeviceAreItsOwn) {
  const Status opened = device_of(brittle(), "absent")->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(opened.error().message, "absent: there is no such camera");
  const auto device = device_of(brittle(), "is unplugged");
  ASSERT_TRUE(device->open());
  ASSERT_TRUE(device->start());
  const Error error = last_error(*device);
  EXPECT_EQ(error.code, ErrorCode::kDisconnected);
  EXPECT_EQ(error.message, "is unplugged: the device has gone");
}

TEST(IsolatedBackend, ACrashIsACameraThatIsGoneAndComesBack) {
  const auto backend = brittle();
  for (const char* moment : {"dies opening", "dies starting", "dies streaming"}) {
    SCOPED_TRACE(moment);
    const auto device = device_of(backend, moment);
    Status status = device->open();
    if (status) {
      status = device->start();
    }
    const Error error = status ? last_error(*device) : status.error();
    EXPECT_EQ(error.code, ErrorCode::kDisconnected);
    EXPECT_THAT(error.message, HasSubstr(std::string(moment)));
    EXPECT_THAT(error.message, HasSubstr("the process that runs brittle for it crashed or hangs"));
    device->close();
  }
  const auto device = device_of(backend, "dies streaming");
  for (int round = 0; round < 200; ++round) {
    ASSERT_TRUE(device->open()) << round;
    ASSERT_TRUE(device->start()) << round;
    ASSERT_EQ(last_error(*device).code, ErrorCode::kDisconnected) << round;
    device->close();
  }
}

TEST(IsolatedBackend, ItsProcessesEndWithTheirOwners) {
  const auto backend = brittle();
  auto device = device_of(backend, "sound");
  ASSERT_TRUE(device->open());
  const int ended = device->wait_fd();
  EXPECT_GE(ended, 0);
  device->close();
  EXPECT_EQ(device->wait_fd(), -1);
  EXPECT_FALSE(device->next(std::chrono::milliseconds(0)));
  EXPECT_EQ(device->start().error().code, ErrorCode::kIllegalState);
}

}  // namespace
}  // namespace kinetrace::hal

// A machine without a single camera.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "backends.hpp"
#include "capture.hpp"

namespace kinetrace::hal::test {
namespace {

TEST(NoCamera, NothingIsListedAndThatIsNoError) {
  use_all_backends();
  EXPECT_TRUE(list_capture_devices().empty());
}

TEST(NoCamera, OpeningOneSaysThatThereIsNone) {
  use_all_backends();
  for (const auto& [backend, name] :
       {std::pair{CaptureBackend::kV4l2, "/dev/video0"}, std::pair{CaptureBackend::kV4l2, "usb-0000:00:14.0-1"},
        std::pair{CaptureBackend::kLibcamera, "camera"}}) {
    CaptureConfig config;
    config.backend = backend;
    config.device = name;
    const Status opened = make_device(config)->open();
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().code, ErrorCode::kNotFound);
    EXPECT_THAT(opened.error().message, ::testing::AllOf(::testing::HasSubstr(name), ::testing::HasSubstr("none")));
  }
}

}  // namespace
}  // namespace kinetrace::hal::test

// Opens, starts and reads devices, for tests that need frames alone.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "capture/capture_device.hpp"
#include "capture/luminance_reader.hpp"

namespace kinetrace::hal::test {

/// An emulated machine may be slow; nothing here measures time.
inline constexpr std::chrono::milliseconds kMaxLateFrames{10'000};

/// A device, not yet open. Throws std::runtime_error where the backend is missing.
[[nodiscard]] std::unique_ptr<CaptureDevice> make_device(const CaptureConfig& config);
/// A device that streams. Throws std::runtime_error, with the device's message.
[[nodiscard]] std::unique_ptr<CaptureDevice> make_streaming(const CaptureConfig& config);

/// The luminance of one captured image, copied.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;
  [[nodiscard]] int at(int x, int y) const { return pixels[static_cast<std::size_t>(y * width + x)]; }
};
/// The next undamaged image of a streaming device. Throws std::runtime_error.
[[nodiscard]] Picture take_picture(CaptureDevice& device, const CaptureConfig& config);

}  // namespace kinetrace::hal::test

// What a live camera needs of the machine: devices, time, waiting. Tests put a scripted one in its place.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "capture/capture_device.hpp"

namespace kinetrace::hal {

/// A descriptor to wait for; `ready` is the answer.
struct WaitHandle {
  int fd = -1;
  bool ready = false;
};

class CaptureEnvironment {
 public:
  CaptureEnvironment() = default;
  CaptureEnvironment(const CaptureEnvironment&) = delete;
  CaptureEnvironment& operator=(const CaptureEnvironment&) = delete;
  virtual ~CaptureEnvironment() = default;

  /// As make_capture_device.
  [[nodiscard]] virtual Result<std::unique_ptr<CaptureDevice>> make_device(const CaptureConfig& config) = 0;
  /// CLOCK_MONOTONIC, the clock of CapturedImage::timestamp_ns.
  [[nodiscard]] virtual std::int64_t now_ns() = 0;
  /// Until one of the handles is ready (or broken, which next() then explains) or that time has come.
  virtual void wait(std::span<WaitHandle> handles, std::int64_t until_ns) = 0;
};

/// The machine itself.
[[nodiscard]] CaptureEnvironment& machine_environment();

}  // namespace kinetrace::hal

// Interface of a live camera to the machine: devices, time, waiting. Tests replace it by a scripted one.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "capture/capture_device.hpp"

namespace kinetrace::hal {

/// A descriptor to wait for; `ready` is the result.
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
  /// Waits until a handle is ready (or broken, which next() then reports) or until that time.
  virtual void wait(std::span<WaitHandle> handles, std::int64_t until_ns) = 0;
};

/// The machine itself.
[[nodiscard]] CaptureEnvironment& machine_environment();

}  // namespace kinetrace::hal

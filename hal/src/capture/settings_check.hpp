// Whether a camera takes its images as it was asked to, where that shows in the images alone.
#pragma once

#include <optional>
#include <string>

#include "kinetrace/core/result.hpp"

namespace kinetrace::hal {

/// What an image was taken with, or is to be. None: not reported, or left to the camera.
struct CaptureSettings {
  std::optional<double> exposure_us{};
  std::optional<double> gain{};
  std::optional<double> period_us{};
};

/// Compares what was asked for with what images report, once settings have had the time to reach the sensor.
class SettingsCheck {
 public:
  SettingsCheck() = default;
  explicit SettingsCheck(const CaptureSettings& asked) : asked_(asked) {}

  /// The stream begins.
  void reset() noexcept { images_ = 0; }
  /// For every image. Errors: kUnsupported (both are printed); `name` is the device's.
  [[nodiscard]] Status check(const std::string& name, const CaptureSettings& got);

 private:
  CaptureSettings asked_;
  int images_ = 0;
};

}  // namespace kinetrace::hal

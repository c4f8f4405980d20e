// Checks requested settings against the metadata of images, where these alone report them.
#pragma once

#include <optional>
#include <string>

#include "kinetrace/core/result.hpp"

namespace kinetrace::hal {

/// Requested or actual settings of an image. None: left to the camera, or not reported.
struct CaptureSettings {
  std::optional<double> exposure_us{};
  std::optional<double> gain{};
  std::optional<double> period_us{};
};

/// Compares requested settings with those that images report, after the images that were still in flight.
class SettingsCheck {
 public:
  SettingsCheck() = default;
  explicit SettingsCheck(const CaptureSettings& asked) : asked_(asked) {}

  /// The stream begins.
  void reset() noexcept { images_ = 0; }
  /// Call it for every image. Errors: kUnsupported (prints both); `name` is the device's.
  [[nodiscard]] Status check(const std::string& name, const CaptureSettings& got);

 private:
  CaptureSettings asked_;
  int images_ = 0;
};

}  // namespace kinetrace::hal

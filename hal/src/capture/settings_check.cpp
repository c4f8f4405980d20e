#include "capture/settings_check.hpp"

#include <algorithm>
#include <cmath>

#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

// Frames in flight still have the previous settings.
constexpr int kSettlingImages = 8;

Status compare(const std::string& name, const char* what, std::optional<double> asked, std::optional<double> got,
               double tolerance) {
  if (!asked || !got || std::abs(*asked - *got) <= tolerance) {
    return {};
  }
  return fail(ErrorCode::kUnsupported, concat(name, ": asked for ", what, " ", number(*asked), ", the camera set ",
                                              number(*got), "; ask for what it can"));
}

// Sensors count exposure in rows and gain in steps.
double exposure_tolerance_us(std::optional<double> exposure_us) {
  constexpr double kRow_us = 50.0;
  return std::max(kRow_us, 0.01 * exposure_us.value_or(0.0));
}

}  // namespace

Status SettingsCheck::check(const std::string& name, const CaptureSettings& got) {
  constexpr double kGainStep = 0.05;
  constexpr double kPeriodPart = 0.01;  // The same tolerance as for a rate that is read back.
  if (++images_ <= kSettlingImages) {
    return {};
  }
  Status status =
      compare(name, "exposure_us", asked_.exposure_us, got.exposure_us, exposure_tolerance_us(asked_.exposure_us));
  if (status) {
    status = compare(name, "gain", asked_.gain, got.gain, kGainStep * asked_.gain.value_or(0.0));
  }
  if (status) {
    status = compare(name, "a frame period in us of", asked_.period_us, got.period_us,
                     kPeriodPart * asked_.period_us.value_or(0.0));
  }
  return status;
}

}  // namespace kinetrace::hal

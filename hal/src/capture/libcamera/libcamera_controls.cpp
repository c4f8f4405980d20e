#include "capture/libcamera/libcamera_controls.hpp"

#include <array>
#include <cmath>
#include <cstdint>

#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

namespace controls = libcamera::controls;

template <typename T>
const libcamera::ControlInfo* find(const libcamera::Camera& camera, const libcamera::Control<T>& control) {
  const auto found = camera.controls().find(&control);
  return found == camera.controls().end() ? nullptr : &found->second;
}

// Tolerance at the limits, in units of the control: rounding.
constexpr double kHalfUnit = 0.5;

template <typename T>
Status check_limits(const libcamera::ControlInfo& limits, double asked, const CaptureInfo& info, const char* what) {
  const auto least = static_cast<double>(limits.min().get<T>());
  const auto most = static_cast<double>(limits.max().get<T>());
  if (asked < least - kHalfUnit || asked > most + kHalfUnit) {
    return fail(ErrorCode::kUnsupported,
                concat(info.name, ": asked for ", what, " ", number(asked), ", the camera sets only ", number(least),
                       " to ", number(most), "; choose a value between"));
  }
  return {};
}

void set_automatic_exposure(const libcamera::Camera& camera, bool automatic, libcamera::ControlList& chosen) {
  if (find(camera, controls::AeEnable) != nullptr) {
    chosen.set(controls::AeEnable, automatic);
  }
}

Status set_exposure(const libcamera::Camera& camera, const CaptureConfig& config, CaptureInfo& info,
                    libcamera::ControlList& chosen) {
  if (!config.exposure_us) {
    set_automatic_exposure(camera, true, chosen);
    return {};
  }
  const libcamera::ControlInfo* limits = find(camera, controls::ExposureTime);
  if (limits == nullptr) {
    return fail(ErrorCode::kUnsupported, info.name + ": libcamera cannot set its exposure; leave exposure_us out");
  }
  if (Status inside = check_limits<std::int32_t>(*limits, *config.exposure_us, info, "exposure_us"); !inside) {
    return inside;
  }
  set_automatic_exposure(camera, false, chosen);
  const auto exposure_us = static_cast<std::int32_t>(std::lround(*config.exposure_us));
  chosen.set(controls::ExposureTime, exposure_us);
  info.exposure_us = exposure_us;
  return {};
}

Status set_gain(const libcamera::Camera& camera, const CaptureConfig& config, CaptureInfo& info,
                libcamera::ControlList& chosen) {
  if (!config.gain) {
    return {};
  }
  const libcamera::ControlInfo* limits = find(camera, controls::AnalogueGain);
  if (limits == nullptr) {
    return fail(ErrorCode::kUnsupported, info.name + ": libcamera cannot set its gain; leave gain out");
  }
  if (Status inside = check_limits<float>(*limits, *config.gain, info, "gain"); !inside) {
    return inside;
  }
  chosen.set(controls::AnalogueGain, static_cast<float>(*config.gain));
  info.gain = config.gain;
  return {};
}

Status set_rate(const libcamera::Camera& camera, const CaptureConfig& config, CaptureInfo& info,
                libcamera::ControlList& chosen) {
  constexpr double kUsPerSecond = 1e6;
  const libcamera::ControlInfo* limits = find(camera, controls::FrameDurationLimits);
  if (limits == nullptr) {
    return {};  // The camera runs at its own rate and does not report it.
  }
  const double period_us = kUsPerSecond / config.rate_hz;
  const auto shortest_us = static_cast<double>(limits->min().get<std::int64_t>());
  const auto longest_us = static_cast<double>(limits->max().get<std::int64_t>());
  if (period_us < shortest_us - kHalfUnit || period_us > longest_us + kHalfUnit) {
    return fail(ErrorCode::kUnsupported,
                concat(info.name, ": asked for ", number(config.rate_hz), " Hz, the camera sets only ",
                       number(kUsPerSecond / longest_us), " to ", number(kUsPerSecond / shortest_us),
                       " Hz in this mode; set image.rate_hz to one of these, or choose a smaller mode"));
  }
  const auto duration = static_cast<std::int64_t>(std::llround(period_us));
  const std::array<std::int64_t, 2> both{duration, duration};
  chosen.set(controls::FrameDurationLimits, libcamera::Span<const std::int64_t, 2>(both));
  info.rate_hz = kUsPerSecond / static_cast<double>(duration);
  return {};
}

}  // namespace

Result<libcamera::ControlList> choose_libcamera_controls(const libcamera::Camera& camera, const CaptureConfig& config,
                                                         CaptureInfo& info) {
  libcamera::ControlList chosen(camera.controls());
  Status status;
  if (config.trigger == TriggerMode::kExternal) {
    status = fail(ErrorCode::kUnsupported,
                  info.name +
                      ": libcamera has no control for an external trigger; set trigger to free_running, or set "
                      "the sensor up by its driver");
  }
  if (status) {
    status = set_exposure(camera, config, info, chosen);
  }
  if (status) {
    status = set_gain(camera, config, info, chosen);
  }
  if (status) {
    status = set_rate(camera, config, info, chosen);
  }
  if (!status) {
    return Unexpected(status.error());
  }
  return chosen;
}

}  // namespace kinetrace::hal

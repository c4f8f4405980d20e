#include "kinetrace/hal/live_camera_config.hpp"

#include <array>
#include <utility>

#include "kinetrace/core/config_check.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

template <typename Enum, std::size_t kCount>
using Names = std::array<std::pair<Enum, std::string_view>, kCount>;

constexpr Names<PixelFormat, 6> kFormats{{{PixelFormat::kGrey8, "grey8"},
                                          {PixelFormat::kGrey10, "grey10"},
                                          {PixelFormat::kGrey16, "grey16"},
                                          {PixelFormat::kYuyv, "yuyv"},
                                          {PixelFormat::kNv12, "nv12"},
                                          {PixelFormat::kMjpeg, "mjpeg"}}};
constexpr Names<CaptureBackend, 2> kBackends{
    {{CaptureBackend::kV4l2, "v4l2"}, {CaptureBackend::kLibcamera, "libcamera"}}};
constexpr Names<TriggerMode, 2> kTriggers{
    {{TriggerMode::kFreeRunning, "free_running"}, {TriggerMode::kExternal, "external"}}};

template <typename Enum, std::size_t kCount>
std::string_view name_of(const Names<Enum, kCount>& names, Enum value) noexcept {
  return names[static_cast<std::size_t>(value)].second;
}

template <typename Enum, std::size_t kCount>
bool find_name(const Names<Enum, kCount>& names, std::string_view text, Enum& value) noexcept {
  for (const auto& [known, name] : names) {
    if (name == text) {
      value = known;
      return true;
    }
  }
  return false;
}

Status validate_view(const std::string& view, const CaptureConfig& config) {
  constexpr int kMaxSide_px = 16384;
  constexpr double kMaxExposure_us = 60e6;
  constexpr double kMaxGain = 1e6;
  if (config.device.empty()) {
    return fail(ErrorCode::kInvalidConfig,
                "devices." + view + " is missing; `kinetrace doctor` lists the devices of this machine");
  }
  if (config.backend == CaptureBackend::kLibcamera && config.trigger == TriggerMode::kExternal) {
    return fail(ErrorCode::kInvalidConfig,
                "image.trigger: libcamera cannot set an external trigger; set it to free_running, and the sensor up by "
                "its driver");
  }
  return first_failure({check_range("image.width_px", config.width_px, 16, kMaxSide_px),
                        check_range("image.height_px", config.height_px, 16, kMaxSide_px),
                        check_range("image.rate_hz", config.rate_hz, 0.01, 1000.0),
                        check_range("image.exposure_us", config.exposure_us.value_or(1.0), 1e-3, kMaxExposure_us),
                        check_range("image.gain", config.gain.value_or(0.0), 0.0, kMaxGain),
                        check_range("image.buffers", config.buffers, 5, 32)});
}

// Both cameras must have the same mode: a difference is a mistake.
Status validate_pair(const CaptureConfig& left, const CaptureConfig& right) {
  if (left.device == right.device) {
    return fail(ErrorCode::kInvalidConfig,
                "devices.right is the left one; name another, or none if one device has both cameras");
  }
  if (left.width_px != right.width_px || left.height_px != right.height_px || left.rate_hz != right.rate_hz) {
    return fail(ErrorCode::kInvalidConfig,
                concat("image: left is ", size_text(left.width_px, left.height_px), " at ", number(left.rate_hz),
                       " Hz, right is ", size_text(right.width_px, right.height_px), " at ", number(right.rate_hz),
                       " Hz; give both the same"));
  }
  return {};
}

}  // namespace

std::string_view to_string(PixelFormat format) noexcept {
  return name_of(kFormats, format);
}
std::string_view to_string(CaptureBackend backend) noexcept {
  return name_of(kBackends, backend);
}
std::string_view to_string(TriggerMode mode) noexcept {
  return name_of(kTriggers, mode);
}
bool from_string(std::string_view text, PixelFormat& format) noexcept {
  return find_name(kFormats, text, format);
}
bool from_string(std::string_view text, CaptureBackend& backend) noexcept {
  return find_name(kBackends, text, backend);
}
bool from_string(std::string_view text, TriggerMode& mode) noexcept {
  return find_name(kTriggers, text, mode);
}

Status LiveCameraConfig::validate() const {
  constexpr double kMax_ms = 600e3;
  const double half_period_ms = 500.0 / left.rate_hz;
  Status status = validate_view("left", left);
  if (status && right) {
    status = first_failure({validate_view("right", *right), validate_pair(left, *right)});
  }
  if (status && !right && left.width_px % 2 != 0) {
    status = fail(
        ErrorCode::kInvalidConfig,
        concat("image.width_px must be even where both cameras are side by side, got ", std::to_string(left.width_px)));
  }
  if (!status) {
    return status;
  }
  return first_failure({check_range("pairing.tolerance_ms", pair_tolerance_ms, 0.001, half_period_ms),
                        check_range("timeouts.stall_ms", stall_timeout_ms, 10.0, kMax_ms),
                        check_range("timeouts.lost_ms", lost_timeout_ms, 10.0, kMax_ms),
                        check_range("timeouts.reopen_first_ms", reopen_first_ms, 1.0, reopen_longest_ms),
                        check_range("timeouts.reopen_longest_ms", reopen_longest_ms, 1.0, kMax_ms)});
}

}  // namespace kinetrace::hal

#include "capture/v4l2/v4l2_controls.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <linux/videodev2.h>
#include <optional>
#include <string>
#include <string_view>

#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

constexpr double kUsPerExposureUnit = 100.0;

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return result;
}

std::string_view text(const unsigned char* field) {
  return reinterpret_cast<const char*>(field);
}

std::optional<v4l2_queryctrl> find_control(const V4l2File& file, __u32 id) {
  v4l2_queryctrl query{};
  query.id = id;
  if (file.call(VIDIOC_QUERYCTRL, &query) != 0 || (query.flags & V4L2_CTRL_FLAG_DISABLED) != 0) {
    return std::nullopt;
  }
  return query;
}

// V4L2 has no standard control for the trigger; drivers use this name.
std::optional<v4l2_queryctrl> find_trigger(const V4l2File& file) {
  v4l2_queryctrl query{};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  while (file.call(VIDIOC_QUERYCTRL, &query) == 0) {
    if ((query.flags & V4L2_CTRL_FLAG_DISABLED) == 0 && lower(text(query.name)) == "trigger mode") {
      return query;
    }
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  return std::nullopt;
}

/// The entry of a menu whose text contains one of the words.
template <std::size_t kWords>
std::optional<__s32> find_entry(const V4l2File& file, const v4l2_queryctrl& menu,
                                const std::array<std::string_view, kWords>& words) {
  for (__s32 index = menu.minimum; index <= menu.maximum; ++index) {
    v4l2_querymenu query{};
    query.id = menu.id;
    query.index = static_cast<__u32>(index);
    if (file.call(VIDIOC_QUERYMENU, &query) != 0) {
      continue;  // Menus may have gaps.
    }
    const std::string entry = lower(text(query.name));
    if (std::any_of(words.begin(), words.end(),
                    [&entry](std::string_view word) { return entry.find(word) != std::string::npos; })) {
      return index;
    }
  }
  return std::nullopt;
}

bool has_entry(const V4l2File& file, __u32 id, __s32 index) {
  v4l2_querymenu query{};
  query.id = id;
  query.index = static_cast<__u32>(index);
  return file.call(VIDIOC_QUERYMENU, &query) == 0;
}

// Sets the control and returns the value that the driver set.
Result<__s32> set_control(const V4l2File& file, __u32 id, __s32 value, const char* what) {
  v4l2_control control{id, value};
  if (const Status set = file.require(VIDIOC_S_CTRL, &control, what); !set) {
    return Unexpected(set.error());
  }
  if (const Status got = file.require(VIDIOC_G_CTRL, &control, what); !got) {
    return Unexpected(got.error());
  }
  return control.value;
}

// The same; another value than requested is an error. `unit`: of the control, in units of the configuration.
Result<double> set_exactly(const V4l2File& file, const v4l2_queryctrl& control, double asked, double unit,
                           const CaptureInfo& info, const char* what) {
  // Beyond the control's range some drivers fail, others clamp: clamping first makes the error print the range for
  // both.
  const double steps =
      std::clamp(std::round(asked / unit), static_cast<double>(control.minimum), static_cast<double>(control.maximum));
  const Result<__s32> got = set_control(file, control.id, static_cast<__s32>(steps), what);
  if (!got) {
    return Unexpected(got.error());
  }
  const double value = *got * unit;
  if (std::abs(value - asked) > unit / 2) {
    return fail(ErrorCode::kUnsupported,
                concat(info.name, ": asked for ", what, " ", number(asked), ", the driver set ", number(value),
                       "; it can: ", number(control.minimum * unit), " to ", number(control.maximum * unit)));
  }
  return value;
}

// Modes have no tolerance.
Status set_mode(const V4l2File& file, __u32 id, __s32 mode, const CaptureInfo& info, const char* what) {
  const Result<__s32> got = set_control(file, id, mode, what);
  if (!got) {
    return Unexpected(got.error());
  }
  if (*got != mode) {
    return fail(ErrorCode::kUnsupported, concat(info.name, ": asked for ", what, " ", std::to_string(mode),
                                                ", the driver set ", std::to_string(*got)));
  }
  return {};
}

// The first of these modes that the device has; false where it has none of them.
Result<bool> choose_exposure_mode(const V4l2File& file, const std::array<__s32, 2>& modes, const CaptureInfo& info) {
  const auto control = find_control(file, V4L2_CID_EXPOSURE_AUTO);
  if (!control) {
    return true;  // One mode only.
  }
  for (const __s32 mode : modes) {
    if (has_entry(file, control->id, mode)) {
      const Status set = set_mode(file, control->id, mode, info, "exposure mode");
      return set ? Result<bool>(true) : Unexpected(set.error());
    }
  }
  return false;
}

Status set_exposure(const V4l2File& file, const CaptureConfig& config, CaptureInfo& info) {
  if (!config.exposure_us) {
    // A device without automatic exposure keeps its exposure.
    const auto automatic = choose_exposure_mode(file, {V4L2_EXPOSURE_APERTURE_PRIORITY, V4L2_EXPOSURE_AUTO}, info);
    return automatic ? Status{} : Unexpected(automatic.error());
  }
  const auto control = find_control(file, V4L2_CID_EXPOSURE_ABSOLUTE);
  if (!control) {
    return fail(ErrorCode::kUnsupported,
                info.name + ": its exposure cannot be set in microseconds; leave exposure_us out");
  }
  const auto manual = choose_exposure_mode(file, {V4L2_EXPOSURE_MANUAL, V4L2_EXPOSURE_SHUTTER_PRIORITY}, info);
  if (!manual) {
    return Unexpected(manual.error());
  }
  if (!*manual) {
    return fail(ErrorCode::kUnsupported, info.name + ": its exposure is always automatic; leave exposure_us out");
  }
  const auto got = set_exactly(file, *control, *config.exposure_us, kUsPerExposureUnit, info, "exposure_us");
  if (!got) {
    return Unexpected(got.error());
  }
  info.exposure_us = *got;
  return {};
}

Status choose_gain_mode(const V4l2File& file, bool automatic, const CaptureInfo& info) {
  if (!find_control(file, V4L2_CID_AUTOGAIN)) {
    return {};
  }
  return set_mode(file, V4L2_CID_AUTOGAIN, automatic ? 1 : 0, info, "gain mode");
}

Status set_gain(const V4l2File& file, const CaptureConfig& config, CaptureInfo& info) {
  if (Status mode = choose_gain_mode(file, !config.gain, info); !mode || !config.gain) {
    return mode;
  }
  auto control = find_control(file, V4L2_CID_GAIN);
  if (!control) {
    control = find_control(file, V4L2_CID_ANALOGUE_GAIN);
  }
  if (!control) {
    return fail(ErrorCode::kUnsupported, info.name + ": its gain cannot be set; leave gain out");
  }
  const auto got = set_exactly(file, *control, *config.gain, 1.0, info, "gain");
  if (!got) {
    return Unexpected(got.error());
  }
  info.gain = *got;
  return {};
}

Status set_trigger(const V4l2File& file, const CaptureConfig& config, const CaptureInfo& info) {
  constexpr std::array<std::string_view, 2> kExternal{"external", "hardware"};
  constexpr std::array<std::string_view, 3> kFree{"free", "off", "disabled"};
  const bool external = config.trigger == TriggerMode::kExternal;
  const auto control = find_trigger(file);
  if (!control) {
    // A device without the control is free-running.
    return external ? Status(fail(ErrorCode::kUnsupported,
                                  info.name + ": has no control 'Trigger Mode'; set trigger to free_running, or set "
                                              "the device up with its maker's tool"))
                    : Status{};
  }
  std::optional<__s32> value = external ? 1 : 0;
  if (control->type == V4L2_CTRL_TYPE_MENU) {
    value = external ? find_entry(file, *control, kExternal) : find_entry(file, *control, kFree);
  }
  if (!value) {
    return fail(ErrorCode::kUnsupported,
                concat(info.name, ": its control 'Trigger Mode' knows no ", to_string(config.trigger), " mode"));
  }
  return set_mode(file, control->id, *value, info, "trigger mode");
}

}  // namespace

std::optional<double> read_v4l2_exposure_us(const V4l2File& file) noexcept {
  v4l2_control control{V4L2_CID_EXPOSURE_ABSOLUTE, 0};
  if (file.call(VIDIOC_G_CTRL, &control) != 0 || control.value <= 0) {
    return std::nullopt;
  }
  return control.value * kUsPerExposureUnit;
}

Status set_v4l2_controls(const V4l2File& file, const CaptureConfig& config, CaptureInfo& info) {
  Status status = set_trigger(file, config, info);
  if (status) {
    status = set_exposure(file, config, info);
  }
  if (status) {
    status = set_gain(file, config, info);
  }
  return status;
}

}  // namespace kinetrace::hal

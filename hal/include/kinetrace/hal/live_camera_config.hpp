// Configuration of a live camera: devices, format, timeouts.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::hal {

/// How pixels arrive. Luminance is what Kinetrace uses; colour is dropped without conversion where the format allows.
enum class PixelFormat : std::uint8_t {
  kGrey8,   ///< V4L2 GREY.
  kGrey10,  ///< V4L2 Y10: 10 bits in the low end of 16.
  kGrey16,  ///< V4L2 Y16.
  kYuyv,    ///< V4L2 YUYV (YUY2).
  kNv12,    ///< V4L2 NV12: the luminance plane comes first.
  kMjpeg,   ///< V4L2 MJPG, JPEG.
};

enum class CaptureBackend : std::uint8_t { kV4l2, kLibcamera };

enum class TriggerMode : std::uint8_t {
  kFreeRunning,  ///< The sensor runs by its own clock.
  kExternal,     ///< Frames follow a trigger line: a missing trigger is not a fault of the device.
};

// Names as in configuration files: "grey8", "grey10", "grey16", "yuyv", "nv12", "mjpeg"; "v4l2", "libcamera";
// "free_running", "external". from_string returns false without a change for any other text.
[[nodiscard]] KINETRACE_API std::string_view to_string(PixelFormat format) noexcept;
[[nodiscard]] KINETRACE_API std::string_view to_string(CaptureBackend backend) noexcept;
[[nodiscard]] KINETRACE_API std::string_view to_string(TriggerMode mode) noexcept;
KINETRACE_API bool from_string(std::string_view text, PixelFormat& format) noexcept;
KINETRACE_API bool from_string(std::string_view text, CaptureBackend& backend) noexcept;
KINETRACE_API bool from_string(std::string_view text, TriggerMode& mode) noexcept;

/// One device as one stream of images.
struct CaptureConfig {
  CaptureBackend backend = CaptureBackend::kV4l2;
  /// A path (/dev/video0), a bus id (usb-0000:00:14.0-3), a serial number, or libcamera's camera id. All but the path
  /// survive unplugging.
  std::string device;
  PixelFormat format = PixelFormat::kGrey8;
  int width_px = 640;  ///< As the device delivers: both views together where one device carries both.
  int height_px = 480;
  double rate_hz = 30.0;
  std::optional<double> exposure_us;  ///< None: automatic.
  std::optional<double> gain;         ///< In the device's own unit. None: automatic.
  TriggerMode trigger = TriggerMode::kFreeRunning;
  int buffers = 6;  ///< Requested from the driver: up to three are held here while the driver fills the others.
};

/// A stereo camera made of one or two devices.
struct KINETRACE_API LiveCameraConfig {
  CaptureConfig left;                  ///< Or the one device with both views side by side, the left view on the left.
  std::optional<CaptureConfig> right;  ///< None: side by side.
  /// Mid-exposure times of a pair differ by at most this, after correction of the offset; at most half a period.
  double pair_tolerance_ms = 4.0;
  /// No pair for this long, exposure time on top: stalled.
  double stall_timeout_ms = 500.0;
  /// Stalled for this long: the device counts as lost, is closed and searched for.
  double lost_timeout_ms = 1500.0;
  /// First pause between attempts to reopen a lost device; doubles up to the longest.
  double reopen_first_ms = 100.0;
  double reopen_longest_ms = 2000.0;

  /// Errors: kInvalidConfig, one line with the key.
  [[nodiscard]] Status validate() const;
};

}  // namespace kinetrace::hal

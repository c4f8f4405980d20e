// Interface of a backend (V4L2, libcamera): one device as one stream of images.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/capture_devices.hpp"
#include "kinetrace/hal/live_camera_config.hpp"

namespace kinetrace::hal {

enum class TimestampKind : std::uint8_t { kStartOfExposure, kEndOfExposure };

/// An image in the device's own buffer. Valid until release().
struct CapturedImage {
  int slot = -1;              ///< For release().
  std::int64_t sequence = 0;  ///< The driver's number, unwrapped beyond 32 bits; gaps are frames that the driver lost.
  std::int64_t timestamp_ns = 0;    ///< CLOCK_MONOTONIC; see CaptureInfo::timestamp_kind.
  bool damaged = false;             ///< The driver flagged an error, or fewer bytes came than the format needs.
  std::span<const std::byte> data;  ///< Compressed: the bytes used.
  std::optional<std::int64_t> exposure_ns{};  ///< Exposure time, if the device reports it.
  std::optional<int> dmabuf_fd{};             ///< The same buffer for other devices, where the driver exports it.
  std::size_t dmabuf_offset_bytes = 0;        ///< Where `data` begins in it.
};

/// Actual settings of the device, read back after configuration. Constant from open() to close().
struct CaptureInfo {
  std::string name;       ///< For messages: card and bus id.
  std::string stable_id;  ///< Finds the same device again after it was unplugged: bus id or serial.
  std::string serial;     ///< Empty where it has none.
  PixelFormat format = PixelFormat::kGrey8;
  int width_px = 0;
  int height_px = 0;
  int stride_bytes = 0;                 ///< From row to row; 0 where compressed.
  double rate_hz = 0.0;                 ///< Zero: not reported.
  std::optional<double> exposure_us{};  ///< As set. None: automatic; CapturedImage may report it.
  std::optional<double> gain{};
  TimestampKind timestamp_kind = TimestampKind::kEndOfExposure;
  bool sequence_counts_losses = false;  ///< Gaps in `sequence` show every lost frame (uvcvideo's do not).
};

/// A device. Used by one thread. open() negotiates and allocates; our code does not allocate afterwards.
class CaptureDevice {
 public:
  CaptureDevice() = default;
  CaptureDevice(const CaptureDevice&) = delete;
  CaptureDevice& operator=(const CaptureDevice&) = delete;
  virtual ~CaptureDevice() = default;

  /// Errors: kNotFound (lists the available devices), kUnsupported (prints requested and actual settings), kIo (busy,
  /// ...).
  [[nodiscard]] virtual Status open() = 0;
  [[nodiscard]] virtual Status start() = 0;
  /// The next image. Errors: kTimeout, kDisconnected (gone), kIo (fatal error of the stream; stop and start may repair
  /// it), kUnsupported (the images contradict the requested settings; prints both).
  [[nodiscard]] virtual Result<CapturedImage> next(std::chrono::milliseconds timeout) = 0;
  /// Returns an image's buffer to the device; harmless after stop().
  virtual void release(int slot) noexcept = 0;
  [[nodiscard]] virtual Status stop() = 0;
  virtual void close() noexcept = 0;
  /// Readable when next() has an image or error; allows waiting for two devices at once.
  [[nodiscard]] virtual int wait_fd() const noexcept = 0;
  [[nodiscard]] virtual const CaptureInfo& info() const noexcept = 0;
};

/// Errors: kUnsupported (the backend is not part of this build; names the package).
[[nodiscard]] Result<std::unique_ptr<CaptureDevice>> make_capture_device(const CaptureConfig& config);

}  // namespace kinetrace::hal

// Interface of all sources of stereo frames: recordings and live cameras.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::hal {

/// States of a camera and the calls that move between them. A call that a state does not list fails with kIllegalState
/// and changes nothing.
///
///     kClosed      open()  -> kConfigured
///     kConfigured  start() -> kStreaming,  close() -> kClosed
///     kStreaming   next(): frame           -> kStreaming
///                          kEndOfStream    -> kStreaming (and again on every further call, until stop)
///                          kTimeout        -> kStreaming, or kStalled after the stall timeout
///                          kDisconnected   -> kLost
///                  stop()  -> kConfigured, close() -> kClosed
///     kStalled     next(): as in kStreaming, kTimeout -> kStalled; a frame leads back to kStreaming
///                  stop()  -> kConfigured, close() -> kClosed
///     kLost        recover(): device back  -> kRecovering
///                             kDisconnected -> kLost
///                  close() -> kClosed
///     kRecovering  next(): frame -> kStreaming, kTimeout -> kRecovering, kDisconnected -> kLost
///                  stop()  -> kConfigured, close() -> kClosed
enum class CameraState : std::uint8_t { kClosed, kConfigured, kStreaming, kStalled, kLost, kRecovering };

[[nodiscard]] constexpr std::string_view to_string(CameraState state) noexcept {
  switch (state) {
    case CameraState::kClosed: return "closed";
    case CameraState::kConfigured: return "configured";
    case CameraState::kStreaming: return "streaming";
    case CameraState::kStalled: return "stalled";
    case CameraState::kLost: return "lost";
    case CameraState::kRecovering: return "recovering";
  }
  return "closed";
}

/// Running totals since start(), across losses of the device. Each unused image counts once, under its reason. Frames
/// without any image are gaps.
struct CameraCounters {
  std::uint64_t frames_delivered = 0;
  std::uint64_t skipped_missing_side = 0;  ///< The other view had no usable image.
  std::uint64_t skipped_unreadable = 0;    ///< An image was damaged.
  std::uint64_t skipped_outdated = 0;      ///< A complete pair, superseded by a newer one.
  std::uint64_t skipped_repeated = 0;      ///< Repeated, or out of order.
  std::uint64_t skipped_wrong_size = 0;    ///< Of another size than announced.
  /// Expected frames without an image of either view. The time from a loss of the camera to its next frame does not
  /// count.
  std::uint64_t gaps = 0;
  std::uint64_t clock_jumps = 0;      ///< Implausible times; delivered times continue evenly.
  std::uint64_t pairing_slips = 0;    ///< Changes of partner after the views drifted apart by half a period.
  std::uint64_t pairing_moves = 0;    ///< Corrections of the pairing by a frame, from the images.
  std::uint64_t stream_restarts = 0;  ///< Automatic restarts of a device's failed stream.
  std::uint64_t stalls = 0;           ///< Times that the stall timeout passed without a frame.
  std::uint64_t losses = 0;           ///< Times that a device was lost.
  std::uint64_t recoveries = 0;       ///< Times that it was reopened.
};

/// Properties of the camera. Constant from open() on.
struct CameraInfo {
  std::string name;
  int width_px = 0;  ///< Of one view's images, as delivered (not rectified).
  int height_px = 0;
  double nominal_rate_hz = 0.0;
  std::optional<std::int64_t> frame_count;  ///< Frames until the end, skipped ones included; none for live cameras.
};

/// A source of synchronised stereo pairs. Used by one thread.
class KINETRACE_API StereoCamera {
 public:
  StereoCamera() = default;
  StereoCamera(const StereoCamera&) = delete;
  StereoCamera& operator=(const StereoCamera&) = delete;
  StereoCamera(StereoCamera&&) = default;
  StereoCamera& operator=(StereoCamera&&) = default;
  virtual ~StereoCamera() = default;

  /// Opens the device or recording. Errors: kNotFound, kIo, kUnsupported, kIllegalState.
  [[nodiscard]] virtual Status open() = 0;
  /// Begins to deliver; a recording starts at its first frame, counters at zero. Errors: kIo, kIllegalState.
  [[nodiscard]] virtual Status start() = 0;
  /// The next pair, at most `timeout` later. Its views live until the next call on this camera. `frame_index` and
  /// `timestamp_ns` increase strictly between frames. Errors: kTimeout, kEndOfStream, kDisconnected, kIllegalState,
  /// kBadFormat (a recording without a single readable pair).
  [[nodiscard]] virtual Result<StereoFrame> next(std::chrono::milliseconds timeout) = 0;
  /// Ends delivery. Errors: kIllegalState.
  [[nodiscard]] virtual Status stop() = 0;
  /// Tries to reopen a lost device. Errors: kDisconnected (still gone), kIllegalState.
  [[nodiscard]] virtual Status recover() = 0;
  /// Releases the device. Allowed in every state.
  virtual void close() noexcept = 0;

  /// Name of an image in messages: its file where it has one.
  [[nodiscard]] virtual std::string image_name(std::int64_t frame_index, bool is_left) const {
    return info().name + (is_left ? ": left" : ": right") + " image of frame " + std::to_string(frame_index);
  }

  [[nodiscard]] virtual CameraState state() const noexcept = 0;
  [[nodiscard]] virtual const CameraInfo& info() const noexcept = 0;
  [[nodiscard]] virtual const CameraCounters& counters() const noexcept = 0;
};

}  // namespace kinetrace::hal

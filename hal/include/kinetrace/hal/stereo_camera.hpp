// Where stereo frames come from: one interface for recordings and live cameras.
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

/// Running totals since start(), losses of the device included. Devices deliver images one by one: each that is not
/// used counts once, under the reason why it was not. Frames of which nothing came at all are gaps.
struct CameraCounters {
  std::uint64_t frames_delivered = 0;
  std::uint64_t skipped_missing_side = 0;  ///< The other view had no usable image.
  std::uint64_t skipped_unreadable = 0;    ///< An image was damaged.
  std::uint64_t skipped_outdated = 0;      ///< A complete pair, but a newer one was there already.
  std::uint64_t skipped_repeated = 0;      ///< Came again, or later than a newer one.
  std::uint64_t skipped_wrong_size = 0;    ///< Of another size than announced.
  /// Frames that were due and of which neither view's image reached us; of a camera that was lost, those until then and
  /// from its first frame afterwards.
  std::uint64_t gaps = 0;
  std::uint64_t clock_jumps = 0;      ///< Times that could not be; what was delivered goes on evenly.
  std::uint64_t pairing_slips = 0;    ///< The views drifted apart by half a period: each now has another partner.
  std::uint64_t pairing_moves = 0;    ///< The images showed that the views were a frame apart: mended from then on.
  std::uint64_t stream_restarts = 0;  ///< Times that a device's stream failed and was started again by itself.
  std::uint64_t stalls = 0;           ///< Times that the stall timeout passed without a frame.
  std::uint64_t losses = 0;           ///< Times that a device was lost.
  std::uint64_t recoveries = 0;       ///< Times that it was taken back.
};

/// What the camera is. Constant from open() on.
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

  /// Takes the device or recording. Errors: kNotFound, kIo, kUnsupported, kIllegalState.
  [[nodiscard]] virtual Status open() = 0;
  /// Begins to deliver; a recording starts at its first frame, counters at zero. Errors: kIo, kIllegalState.
  [[nodiscard]] virtual Status start() = 0;
  /// The next pair, at most `timeout` later. Its views live until the next call on this camera. `frame_index` and
  /// `timestamp_ns` increase strictly between frames. Errors: kTimeout, kEndOfStream, kDisconnected, kIllegalState,
  /// kBadFormat (a recording without a single readable pair).
  [[nodiscard]] virtual Result<StereoFrame> next(std::chrono::milliseconds timeout) = 0;
  /// Ends delivery. Errors: kIllegalState.
  [[nodiscard]] virtual Status stop() = 0;
  /// Takes a lost device back. Errors: kDisconnected (still gone), kIllegalState.
  [[nodiscard]] virtual Status recover() = 0;
  /// Gives the device back. Allowed in every state.
  virtual void close() noexcept = 0;

  /// What an image is called in messages: its file where it has one.
  [[nodiscard]] virtual std::string image_name(std::int64_t frame_index, bool is_left) const {
    return info().name + (is_left ? ": left" : ": right") + " image of frame " + std::to_string(frame_index);
  }

  [[nodiscard]] virtual CameraState state() const noexcept = 0;
  [[nodiscard]] virtual const CameraInfo& info() const noexcept = 0;
  [[nodiscard]] virtual const CameraCounters& counters() const noexcept = 0;
};

}  // namespace kinetrace::hal

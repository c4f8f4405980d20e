// The states of a live camera, and the timers of their transitions.
#pragma once

#include <cstdint>
#include <optional>

#include "kinetrace/hal/stereo_camera.hpp"

namespace kinetrace::hal {

/// All in nanoseconds.
struct CameraTimeouts {
  std::int64_t stall_ns = 0;            ///< Without a frame until the camera is stalled, plus the exposure time.
  std::optional<std::int64_t> lost_ns;  ///< After that, until it is lost. None: missing data is never a loss.
  std::int64_t reopen_first_ns = 0;     ///< From a loss to the first attempt to reopen.
  std::int64_t reopen_longest_ns = 0;   ///< The interval doubles with each failed attempt, up to this.
};

/// Events of a camera. The first five are successful calls of StereoCamera.
enum class CameraEvent : std::uint8_t {
  kOpened,
  kStarted,
  kFrame,
  kStopped,
  kReopened,
  kReopenFailed,
  kStallTimeout,
  kLost,  ///< The devices have been closed, after an error or the lost timeout.
  kClosed,
};

/// Pure: the caller passes the time; no I/O.
class CameraStateMachine {
 public:
  explicit CameraStateMachine(const CameraTimeouts& timeouts) : timeouts_(timeouts) {}

  [[nodiscard]] CameraState state() const noexcept { return state_; }
  /// Whether the state has a transition for the event. A call is legal in the states that accept its success.
  [[nodiscard]] bool accepts(CameraEvent event) const noexcept;
  /// Changes state and sets the timers. An event that is not accepted changes nothing.
  void handle(CameraEvent event, std::int64_t now_ns) noexcept;

  /// When the last frame was delivered, or streaming began.
  [[nodiscard]] std::int64_t last_frame_ns() const noexcept { return last_frame_ns_; }
  /// The first moment at which missing data is a loss.
  [[nodiscard]] std::int64_t loss_due_ns(std::int64_t exposure_ns) const noexcept;
  /// The timeout that has expired and is to be handled: kStallTimeout or kLost.
  [[nodiscard]] std::optional<CameraEvent> expired(std::int64_t now_ns, std::int64_t exposure_ns) const noexcept;
  [[nodiscard]] bool is_reopen_due(std::int64_t now_ns) const noexcept { return now_ns >= next_reopen_ns_; }

 private:
  CameraTimeouts timeouts_;
  CameraState state_ = CameraState::kClosed;
  std::int64_t last_frame_ns_ = 0;
  std::int64_t reopen_interval_ns_ = 0;
  std::int64_t next_reopen_ns_ = 0;
};

}  // namespace kinetrace::hal

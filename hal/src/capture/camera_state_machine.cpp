#include "capture/camera_state_machine.hpp"

#include <algorithm>
#include <limits>

namespace kinetrace::hal {
namespace {

struct Transition {
  CameraState from;
  CameraEvent event;
  CameraState to;
};

// As documented at CameraState, without kClosed, which leads from every state to kClosed.
constexpr Transition kTransitions[] = {
    {CameraState::kClosed, CameraEvent::kOpened, CameraState::kConfigured},
    {CameraState::kConfigured, CameraEvent::kStarted, CameraState::kStreaming},
    {CameraState::kStreaming, CameraEvent::kFrame, CameraState::kStreaming},
    {CameraState::kStreaming, CameraEvent::kStallTimeout, CameraState::kStalled},
    {CameraState::kStreaming, CameraEvent::kLost, CameraState::kLost},
    {CameraState::kStreaming, CameraEvent::kStopped, CameraState::kConfigured},
    {CameraState::kStalled, CameraEvent::kFrame, CameraState::kStreaming},
    {CameraState::kStalled, CameraEvent::kLost, CameraState::kLost},
    {CameraState::kStalled, CameraEvent::kStopped, CameraState::kConfigured},
    {CameraState::kLost, CameraEvent::kReopened, CameraState::kRecovering},
    {CameraState::kLost, CameraEvent::kReopenFailed, CameraState::kLost},
    {CameraState::kRecovering, CameraEvent::kFrame, CameraState::kStreaming},
    {CameraState::kRecovering, CameraEvent::kLost, CameraState::kLost},
    {CameraState::kRecovering, CameraEvent::kStopped, CameraState::kConfigured},
};

std::optional<CameraState> next_state(CameraState from, CameraEvent event) noexcept {
  if (event == CameraEvent::kClosed) {
    return CameraState::kClosed;
  }
  const auto* const found = std::find_if(std::begin(kTransitions), std::end(kTransitions),
                                         [&](const Transition& row) { return row.from == from && row.event == event; });
  return found == std::end(kTransitions) ? std::nullopt : std::optional(found->to);
}

}  // namespace

bool CameraStateMachine::accepts(CameraEvent event) const noexcept {
  return next_state(state_, event).has_value();
}

void CameraStateMachine::handle(CameraEvent event, std::int64_t now_ns) noexcept {
  const std::optional<CameraState> next = next_state(state_, event);
  if (!next) {
    return;
  }
  state_ = *next;
  switch (event) {
    case CameraEvent::kStarted:
    case CameraEvent::kReopened:
    case CameraEvent::kFrame: last_frame_ns_ = now_ns; break;
    case CameraEvent::kLost:
      reopen_interval_ns_ = timeouts_.reopen_first_ns;
      next_reopen_ns_ = now_ns + reopen_interval_ns_;
      break;
    case CameraEvent::kReopenFailed:
      reopen_interval_ns_ = std::min(2 * reopen_interval_ns_, timeouts_.reopen_longest_ns);
      next_reopen_ns_ = now_ns + reopen_interval_ns_;
      break;
    case CameraEvent::kOpened:
    case CameraEvent::kStopped:
    case CameraEvent::kStallTimeout:
    case CameraEvent::kClosed: break;
  }
}

std::int64_t CameraStateMachine::loss_due_ns(std::int64_t exposure_ns) const noexcept {
  return timeouts_.lost_ns ? last_frame_ns_ + timeouts_.stall_ns + exposure_ns + *timeouts_.lost_ns + 1
                           : std::numeric_limits<std::int64_t>::max();
}

std::optional<CameraEvent> CameraStateMachine::expired(std::int64_t now_ns, std::int64_t exposure_ns) const noexcept {
  if (now_ns >= loss_due_ns(exposure_ns)) {
    return CameraEvent::kLost;
  }
  if (now_ns - last_frame_ns_ > timeouts_.stall_ns + exposure_ns && accepts(CameraEvent::kStallTimeout)) {
    return CameraEvent::kStallTimeout;
  }
  return std::nullopt;
}

}  // namespace kinetrace::hal

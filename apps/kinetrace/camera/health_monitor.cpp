#include "camera/health_monitor.hpp"

#include <algorithm>
#include <iterator>

namespace kinetrace::app {
namespace {

// Health reasons of the camera's counters.
struct Symptom {
  std::uint64_t hal::CameraCounters::*counter;
  HealthReason reason;
};
constexpr std::array<Symptom, 12> kSymptoms{{
    {&hal::CameraCounters::skipped_missing_side, HealthReason::kFramesLost},
    {&hal::CameraCounters::gaps, HealthReason::kFramesLost},
    {&hal::CameraCounters::skipped_unreadable, HealthReason::kFramesDamaged},
    {&hal::CameraCounters::skipped_outdated, HealthReason::kFramesOutdated},
    {&hal::CameraCounters::skipped_repeated, HealthReason::kFramesRepeated},
    {&hal::CameraCounters::skipped_wrong_size, HealthReason::kFramesOfWrongSize},
    {&hal::CameraCounters::clock_jumps, HealthReason::kClockJumped},
    {&hal::CameraCounters::pairing_slips, HealthReason::kViewsOutOfStep},
    {&hal::CameraCounters::pairing_moves, HealthReason::kViewsOutOfStep},
    {&hal::CameraCounters::stream_restarts, HealthReason::kFramesLost},
    {&hal::CameraCounters::stalls, HealthReason::kCameraStalled},
    {&hal::CameraCounters::losses, HealthReason::kCameraLost},
}};

}  // namespace

void HealthMonitor::Account::note(HealthReason reason, std::uint64_t count) noexcept {
  if (count == 0) {
    return;
  }
  HealthEntry& entry = entries[static_cast<std::size_t>(reason)];
  if (entry.count == 0) {
    entry = {reason, 0, frame, frame};
  }
  entry.count += count;
  entry.last_frame = frame;
  last_trouble = frame;
}

// Reasons noted before the first frame are dated to the first frame.
void HealthMonitor::Account::begin_at(std::int64_t first) noexcept {
  for (HealthEntry& entry : entries) {
    if (entry.count > 0) {
      entry.first_frame = first;
      entry.last_frame = first;
      last_trouble = first;
    }
  }
}

void HealthMonitor::Account::update() noexcept {
  const bool is_lost = camera == hal::CameraState::kLost;
  const bool is_recent = last_trouble && frame - *last_trouble <= kRecentFrames;
  const bool is_halting = camera == hal::CameraState::kStalled || camera == hal::CameraState::kRecovering;
  state = is_lost ? HealthState::kLost : is_recent || is_halting ? HealthState::kDegraded : HealthState::kOk;
  worst = std::max(worst, state);
}

void HealthMonitor::note(HealthReason reason, std::uint64_t count) noexcept {
  const std::lock_guard lock(mutex_);
  now_.note(reason, count);
  now_.update();
}

void HealthMonitor::observe(hal::CameraState camera, const hal::CameraCounters& counters) noexcept {
  const std::lock_guard lock(mutex_);
  now_.camera = camera;
  for (const Symptom& symptom : kSymptoms) {
    now_.note(symptom.reason, counters.*symptom.counter - now_.seen.*symptom.counter);
  }
  now_.seen = counters;
  now_.update();
}

void HealthMonitor::observe(const FrameEstimate& newest) noexcept {
  const std::lock_guard lock(mutex_);
  const bool had_frame = now_.frame >= 0;
  now_.frame = newest.frame_index;
  if (!had_frame) {
    now_.begin_at(newest.frame_index);
  }
  const BodyStatus pose = newest.camera.status;
  // The first frame has no predecessor to track against.
  now_.note(HealthReason::kPoseLost,
            had_frame && (pose == BodyStatus::kPropagated || pose == BodyStatus::kLost) ? 1 : 0);
  now_.update();
}

Condition HealthMonitor::condition() const noexcept {
  const Account account = copy();
  Condition now{account.state, {}};
  for (std::size_t i = 0; i < kHealthReasonCount; ++i) {
    const HealthEntry& entry = account.entries[i];
    now.reasons[i] = entry.count > 0 && account.frame - entry.last_frame <= kRecentFrames;
  }
  return now;
}

std::vector<HealthEntry> HealthMonitor::entries() const {
  const Account account = copy();
  std::vector<HealthEntry> happened;
  std::copy_if(account.entries.begin(), account.entries.end(), std::back_inserter(happened),
               [](const HealthEntry& entry) { return entry.count > 0; });
  return happened;
}

}  // namespace kinetrace::app

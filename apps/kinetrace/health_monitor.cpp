#include "health_monitor.hpp"

#include <algorithm>
#include <iterator>

namespace kinetrace::app {
namespace {

// Which of the camera's totals mean what.
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
    {&hal::CameraCounters::pairing_slips, HealthReason::kEyesOutOfStep},
    {&hal::CameraCounters::pairing_moves, HealthReason::kEyesOutOfStep},
    {&hal::CameraCounters::stream_restarts, HealthReason::kFramesLost},
    {&hal::CameraCounters::stalls, HealthReason::kCameraStalled},
    {&hal::CameraCounters::losses, HealthReason::kCameraLost},
}};

}  // namespace

void HealthMonitor::note(HealthReason reason, std::uint64_t count) noexcept {
  if (count == 0) {
    return;
  }
  HealthEntry& entry = entries_[static_cast<std::size_t>(reason)];
  if (entry.count == 0) {
    entry = {reason, 0, frame_, frame_};
  }
  entry.count += count;
  entry.last_frame = frame_;
  last_trouble_ = frame_;
  update();
}

void HealthMonitor::update() noexcept {
  const bool is_lost = camera_ == hal::CameraState::kLost;
  const bool is_recent = last_trouble_ && frame_ - *last_trouble_ <= kRecentFrames;
  const bool is_halting = camera_ == hal::CameraState::kStalled || camera_ == hal::CameraState::kRecovering;
  state_ = is_lost ? HealthState::kLost : is_recent || is_halting ? HealthState::kDegraded : HealthState::kOk;
  worst_ = std::max(worst_, state_);
}

void HealthMonitor::observe(hal::CameraState camera, const hal::CameraCounters& counters) noexcept {
  camera_ = camera;
  for (const Symptom& symptom : kSymptoms) {
    note(symptom.reason, counters.*symptom.counter - seen_.*symptom.counter);
  }
  seen_ = counters;
  update();
}

void HealthMonitor::observe(const FrameEstimate& newest) noexcept {
  const bool had_frame = frame_ >= 0;
  frame_ = newest.frame_index;
  const BodyStatus pose = newest.camera.status;
  // The first frame of all has nothing to be tracked against.
  note(HealthReason::kPoseLost, had_frame && (pose == BodyStatus::kPropagated || pose == BodyStatus::kLost) ? 1 : 0);
  update();
}

std::vector<HealthEntry> HealthMonitor::entries() const {
  std::vector<HealthEntry> happened;
  std::copy_if(entries_.begin(), entries_.end(), std::back_inserter(happened),
               [](const HealthEntry& entry) { return entry.count > 0; });
  return happened;
}

}  // namespace kinetrace::app

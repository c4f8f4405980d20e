// Watches a run and keeps account of what was wrong with it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/health.hpp"
#include "kinetrace/hal/stereo_camera.hpp"

namespace kinetrace::app {

/// Degraded while something was wrong within the last `kRecentFrames` frames, lost while the camera is. Never
/// allocates, except for entries().
class HealthMonitor {
 public:
  static constexpr std::int64_t kRecentFrames = 30;

  /// After every call of the camera, with what it has counted so far.
  void observe(hal::CameraState camera, const hal::CameraCounters& counters) noexcept;
  /// After every processed frame.
  void observe(const FrameEstimate& newest) noexcept;
  void note(HealthReason reason, std::uint64_t count = 1) noexcept;

  [[nodiscard]] HealthState state() const noexcept { return state_; }
  [[nodiscard]] HealthState worst() const noexcept { return worst_; }
  [[nodiscard]] hal::CameraState camera() const noexcept { return camera_; }
  /// The newest processed frame; -1 before the first.
  [[nodiscard]] std::int64_t frame() const noexcept { return frame_; }
  /// By HealthReason; a count of 0 never happened.
  [[nodiscard]] const std::array<HealthEntry, kHealthReasonCount>& all() const noexcept { return entries_; }
  /// Whatever happened at least once, in the order of HealthReason.
  [[nodiscard]] std::vector<HealthEntry> entries() const;

 private:
  void update() noexcept;

  std::array<HealthEntry, kHealthReasonCount> entries_{};
  hal::CameraCounters seen_;
  hal::CameraState camera_ = hal::CameraState::kClosed;
  std::int64_t frame_ = -1;
  std::optional<std::int64_t> last_trouble_;  ///< Frame.
  HealthState state_ = HealthState::kOk;
  HealthState worst_ = HealthState::kOk;
};

}  // namespace kinetrace::app

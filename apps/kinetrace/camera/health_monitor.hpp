// Monitors the health of a run and counts the reasons of degradation.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/health.hpp"
#include "kinetrace/hal/stereo_camera.hpp"

namespace kinetrace::app {

/// Health of a run at one moment.
struct Condition {
  HealthState state = HealthState::kOk;
  std::bitset<kHealthReasonCount> reasons;  ///< By HealthReason: recent ones.

  [[nodiscard]] bool operator==(const Condition&) const noexcept = default;
};

/// Degraded while a reason was noted within the last `kRecentFrames` frames, lost while the camera is lost. Never
/// allocates, except for entries(). Thread-safe.
class HealthMonitor {
 public:
  static constexpr std::int64_t kRecentFrames = 30;

  HealthMonitor() = default;
  HealthMonitor(const HealthMonitor& other) : now_(other.copy()) {}
  HealthMonitor& operator=(const HealthMonitor&) = delete;
  ~HealthMonitor() = default;

  /// Call after every call of the camera, with its running totals.
  void observe(hal::CameraState camera, const hal::CameraCounters& counters) noexcept;
  /// Call after every processed frame.
  void observe(const FrameEstimate& newest) noexcept;
  void note(HealthReason reason, std::uint64_t count = 1) noexcept;

  [[nodiscard]] HealthState state() const noexcept { return copy().state; }
  [[nodiscard]] HealthState worst() const noexcept { return copy().worst; }
  [[nodiscard]] hal::CameraState camera() const noexcept { return copy().camera; }
  /// The newest processed frame; -1 before the first.
  [[nodiscard]] std::int64_t frame() const noexcept { return copy().frame; }
  /// Current health.
  [[nodiscard]] Condition condition() const noexcept;
  /// By HealthReason; a count of 0: never noted.
  [[nodiscard]] std::array<HealthEntry, kHealthReasonCount> all() const noexcept { return copy().entries; }
  /// Reasons noted at least once, in the order of HealthReason.
  [[nodiscard]] std::vector<HealthEntry> entries() const;

 private:
  struct Account {
    std::array<HealthEntry, kHealthReasonCount> entries{};
    hal::CameraCounters seen;
    hal::CameraState camera = hal::CameraState::kClosed;
    std::int64_t frame = -1;
    std::optional<std::int64_t> last_trouble;  ///< Frame.
    HealthState state = HealthState::kOk;
    HealthState worst = HealthState::kOk;

    void note(HealthReason reason, std::uint64_t count) noexcept;
    void begin_at(std::int64_t first) noexcept;
    void update() noexcept;
  };
  [[nodiscard]] Account copy() const noexcept {
    const std::lock_guard lock(mutex_);
    return now_;
  }

  mutable std::mutex mutex_;
  Account now_;
};

}  // namespace kinetrace::app

// Keeps both views of a camera paired by time.
#pragma once

#include "camera/health_monitor.hpp"
#include "kinetrace/hal/live_stereo_camera.hpp"
#include "kinetrace/hal/sync_monitor.hpp"

namespace kinetrace::app {

/// Notes views that SyncMonitor finds out of step. After `kMinAgreeing` consecutive measurements that agree, the camera
/// pairs its images with those of the frame before or after. The next move reverts one that did not help; after
/// `kMaxMoves` without success faults are only noted. Never allocates.
class PairingKeeper {
 public:
  static constexpr int kMinAgreeing = 6;
  static constexpr int kMaxMoves = 4;

  /// `camera`: null where pairing cannot be changed (recordings, one device with both views). It must outlive this.
  explicit PairingKeeper(hal::LiveStereoCamera* camera) : camera_(camera) {}

  /// Takes a new measurement. True if the pairing has changed, so that the monitor has to assess anew.
  [[nodiscard]] bool process(const hal::SyncReport& report, HealthMonitor& health) noexcept;
  [[nodiscard]] bool can_shift_pairing() const noexcept { return camera_ != nullptr && moves_ < kMaxMoves; }

 private:
  [[nodiscard]] bool shift_pairing(const hal::SyncReport& report) noexcept;

  hal::LiveStereoCamera* camera_;
  int moves_ = 0;  ///< Since the views were last in step.
};

}  // namespace kinetrace::app

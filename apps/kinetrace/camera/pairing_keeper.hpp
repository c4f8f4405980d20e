// Keeps both views of a camera on the same moment.
#pragma once

#include "camera/health_monitor.hpp"
#include "kinetrace/hal/live_stereo_camera.hpp"
#include "kinetrace/hal/sync_monitor.hpp"

namespace kinetrace::app {

/// What SyncMonitor finds out of step is noted, and, once `kSure` measurements in a row say the same, mended: the
/// camera pairs its images with those of the frame before or after. A move that does not help is taken back by the next
/// one; after `kMaxMoves` without success it is left at noting. Never allocates.
class PairingKeeper {
 public:
  static constexpr int kSure = 6;
  static constexpr int kMaxMoves = 4;

  /// `camera`: null where there is nothing to be mended (recordings, one device with both views). It must outlive this.
  explicit PairingKeeper(hal::LiveStereoCamera* camera) : camera_(camera) {}

  /// A new measurement. True if views are paired in another way from now on, so that the monitor has to assess anew.
  [[nodiscard]] bool process(const hal::SyncReport& report, HealthMonitor& health) noexcept;
  [[nodiscard]] bool can_mend() const noexcept { return camera_ != nullptr && moves_ < kMaxMoves; }

 private:
  [[nodiscard]] bool mend(const hal::SyncReport& report) noexcept;

  hal::LiveStereoCamera* camera_;
  int moves_ = 0;  ///< Since the views were last in step.
};

}  // namespace kinetrace::app

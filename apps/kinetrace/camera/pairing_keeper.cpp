#include "camera/pairing_keeper.hpp"

namespace kinetrace::app {

bool PairingKeeper::process(const hal::SyncReport& report, HealthMonitor& health) noexcept {
  switch (report.verdict) {
    case hal::SyncVerdict::kUnknown: break;
    case hal::SyncVerdict::kInStep: moves_ = 0; break;
    case hal::SyncVerdict::kRightLate:
    case hal::SyncVerdict::kRightEarly: health.note(HealthReason::kViewsOutOfStep); return shift_pairing(report);
  }
  return false;
}

bool PairingKeeper::shift_pairing(const hal::SyncReport& report) noexcept {
  if (!can_shift_pairing() || report.agreeing < kMinAgreeing) {
    return false;
  }
  // The right image of a moment arrives one frame after the left one, or one frame before.
  const bool moved = camera_->move_pairing(report.verdict == hal::SyncVerdict::kRightLate ? 1 : -1);
  moves_ += moved ? 1 : 0;
  return moved;
}

}  // namespace kinetrace::app

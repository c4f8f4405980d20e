#include "pairing_keeper.hpp"

namespace kinetrace::app {

void PairingKeeper::process(const RectifiedPair& pair, HealthMonitor& health) noexcept {
  if (!monitor_.process(pair)) {
    return;
  }
  const hal::SyncReport& report = monitor_.report();
  switch (report.verdict) {
    case hal::SyncVerdict::kUnknown: break;
    case hal::SyncVerdict::kInStep: moves_ = 0; break;
    case hal::SyncVerdict::kRightLate:
    case hal::SyncVerdict::kRightEarly:
      health.note(HealthReason::kEyesOutOfStep);
      mend(report);
      break;
  }
}

void PairingKeeper::mend(const hal::SyncReport& report) noexcept {
  if (camera_ == nullptr || report.agreeing < kSure || moves_ == kMostMoves) {
    return;
  }
  // The right image of a moment comes a frame later than the left one, or earlier.
  if (camera_->move_pairing(report.verdict == hal::SyncVerdict::kRightLate ? 1 : -1)) {
    ++moves_;
    monitor_.restart();
  }
}

}  // namespace kinetrace::app

#include "kinetrace/tracking/life_cycle.hpp"

namespace kinetrace::tracking {
namespace {

LifeState next_tentative(const LifeEvidence& evidence) noexcept {
  if (evidence.detected) {
    return evidence.often_detected ? LifeState::kConfirmed : LifeState::kTentative;
  }
  const bool gone = evidence.vanished || evidence.missed || evidence.missed_tentative || evidence.coasted_too_long;
  return gone ? LifeState::kEnded : LifeState::kTentative;
}

LifeState next_confirmed(LifeState state, const LifeEvidence& evidence) noexcept {
  if (evidence.detected) {
    return LifeState::kConfirmed;
  }
  if (evidence.coasted_too_long || (!evidence.has_prediction && (evidence.vanished || evidence.missed))) {
    return LifeState::kEnded;
  }
  if (state == LifeState::kDormant || evidence.missed_in_sight) {
    return LifeState::kDormant;
  }
  return evidence.in_plain_sight ? LifeState::kMissing : LifeState::kHidden;
}

}  // namespace

LifeState next(LifeState state, const LifeEvidence& evidence) noexcept {
  switch (state) {
    case LifeState::kFree:
    case LifeState::kEnded: return state;
    case LifeState::kTentative: return evidence.terminated ? LifeState::kEnded : next_tentative(evidence);
    case LifeState::kConfirmed:
    case LifeState::kHidden:
    case LifeState::kMissing:
    case LifeState::kDormant: return evidence.terminated ? LifeState::kEnded : next_confirmed(state, evidence);
  }
  return state;
}

}  // namespace kinetrace::tracking

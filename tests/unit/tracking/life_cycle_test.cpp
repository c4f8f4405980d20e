#include "kinetrace/tracking/life_cycle.hpp"

#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::tracking {
namespace {

struct Transition {
  std::string name;
  LifeState from = LifeState::kFree;
  LifeEvidence evidence;
  LifeState to = LifeState::kFree;
};

LifeEvidence evidence(void (*set)(LifeEvidence&)) {
  LifeEvidence out;
  set(out);
  return out;
}

const LifeEvidence kNothing;
const LifeEvidence kDetected = evidence([](LifeEvidence& e) { e.detected = true; });
const LifeEvidence kOftenDetected = evidence([](LifeEvidence& e) { e.detected = e.often_detected = true; });
const LifeEvidence kVanishedWithoutPrediction = evidence([](LifeEvidence& e) { e.in_plain_sight = e.vanished = true; });
const LifeEvidence kMissedWithoutPrediction = evidence([](LifeEvidence& e) { e.in_plain_sight = e.missed = true; });
const LifeEvidence kTentativeMissed = evidence([](LifeEvidence& e) { e.missed_tentative = true; });
const LifeEvidence kInSight = evidence([](LifeEvidence& e) { e.has_prediction = e.in_plain_sight = true; });
const LifeEvidence kOutOfSight = evidence([](LifeEvidence& e) { e.has_prediction = e.vanished = e.missed = true; });
const LifeEvidence kLongInSight =
    evidence([](LifeEvidence& e) { e.has_prediction = e.in_plain_sight = e.missed = e.missed_in_sight = true; });
const LifeEvidence kCoastedTooLong =
    evidence([](LifeEvidence& e) { e.has_prediction = e.missed = e.coasted_too_long = true; });
const LifeEvidence kTerminated = evidence([](LifeEvidence& e) { e.detected = e.terminated = true; });

class LifeCycle : public ::testing::TestWithParam<Transition> {};

TEST_P(LifeCycle, GoesWhereTheTableSays) {
  EXPECT_EQ(next(GetParam().from, GetParam().evidence), GetParam().to);
}

std::vector<Transition> transitions() {
  using enum LifeState;
  std::vector<Transition> all{
      {"TentativeIsDetected", kTentative, kDetected, kTentative},
      {"TentativeIsOftenDetected", kTentative, kOftenDetected, kConfirmed},
      {"TentativeIsMissedOnce", kTentative, kNothing, kTentative},
      {"TentativeIsLookedForInVain", kTentative, kTentativeMissed, kEnded},
      {"TentativeVanishes", kTentative, kVanishedWithoutPrediction, kEnded},
      {"TentativeIsMissedForLong", kTentative, kMissedWithoutPrediction, kEnded},
      {"TentativeCoastsTooLong", kTentative, kCoastedTooLong, kEnded},
      {"FreeStaysFree", kFree, kOftenDetected, kFree},
      {"EndedStaysEnded", kEnded, kOftenDetected, kEnded},
  };
  all.push_back({"DormantStaysSoInSight", kDormant, kInSight, kDormant});
  all.push_back({"DormantStaysSoOutOfSight", kDormant, kOutOfSight, kDormant});
  const std::array<std::pair<LifeState, const char*>, 4> confirmed{
      {{kConfirmed, "Confirmed"}, {kHidden, "Hidden"}, {kMissing, "Missing"}, {kDormant, "Dormant"}}};
  for (const auto& [from, name] : confirmed) {
    const std::string of = name;
    all.push_back({of + "IsDetected", from, kDetected, kConfirmed});
    if (from != kDormant) {
      all.push_back({of + "IsMissedInSight", from, kInSight, kMissing});
      all.push_back({of + "IsOutOfSight", from, kOutOfSight, kHidden});
    }
    all.push_back({of + "IsMissedInSightForLong", from, kLongInSight, kDormant});
    all.push_back({of + "WithoutAPredictionVanishes", from, kVanishedWithoutPrediction, kEnded});
    all.push_back({of + "WithoutAPredictionIsMissedForLong", from, kMissedWithoutPrediction, kEnded});
    all.push_back({of + "CoastsTooLong", from, kCoastedTooLong, kEnded});
    all.push_back({of + "HasPassedToAnother", from, kTerminated, kEnded});
  }
  all.push_back({"TentativeHasPassedToAnother", kTentative, kTerminated, kEnded});
  return all;
}

INSTANTIATE_TEST_SUITE_P(Table, LifeCycle, ::testing::ValuesIn(transitions()),
                         [](const auto& transition) { return transition.param.name; });

TEST(LifeCycleStates, ArePublishedAsThree) {
  EXPECT_EQ(track_state(LifeState::kTentative), TrackState::kTentative);
  EXPECT_EQ(track_state(LifeState::kConfirmed), TrackState::kConfirmed);
  for (const LifeState unseen : {LifeState::kHidden, LifeState::kMissing, LifeState::kDormant}) {
    EXPECT_EQ(track_state(unseen), TrackState::kPropagated);
    EXPECT_TRUE(is_alive(unseen));
  }
  EXPECT_FALSE(is_alive(LifeState::kFree));
  EXPECT_FALSE(is_alive(LifeState::kEnded));
}

}  // namespace
}  // namespace kinetrace::tracking

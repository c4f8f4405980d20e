// Pairing on streams whose true partners are known: shot k of either view carries the sequence number k.
#include "kinetrace/hal/frame_synchronizer.hpp"

#include <algorithm>
#include <functional>
#include <random>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::hal {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kPeriod = 33 * kMs;
constexpr std::int64_t kTolerance = 4 * kMs;

/// One frame in transit.
struct Arrival {
  View view = View::kLeft;
  SyncFrame frame;
  std::int64_t at_ns = 0;
};

struct Scenario {
  int shots = 300;
  std::int64_t tolerance_ns = kTolerance;
  std::int64_t first_sequence = 0;
  /// By view and shot number. Where empty: nominal, and nothing is lost.
  std::function<std::int64_t(View, int)> stamp = [](View /*view*/, int shot) { return shot * kPeriod; };
  std::function<bool(View, int)> lost = [](View /*view*/, int /*shot*/) { return false; };
  std::function<std::int64_t(View, int)> latency = [](View /*view*/, int /*shot*/) { return 5 * kMs; };
};

struct Outcome {
  std::vector<SyncPair> pairs;
  std::vector<SyncDrop> drops;
  SyncCounters counters;
  double offset_ms = 0.0;
  double drift_ppm = 0.0;
  int delivered = 0;

  /// Pairs of different shots.
  [[nodiscard]] int wrong() const {
    return static_cast<int>(std::count_if(
        pairs.begin(), pairs.end(), [](const SyncPair& pair) { return pair.left.sequence != pair.right.sequence; }));
  }
  [[nodiscard]] int dropped(View view) const {
    return static_cast<int>(
        std::count_if(drops.begin(), drops.end(), [view](const SyncDrop& drop) { return drop.view == view; }));
  }
};

Outcome play(const Scenario& scenario) {
  std::vector<Arrival> arrivals;
  for (int shot = 0; shot < scenario.shots; ++shot) {
    for (const View view : {View::kLeft, View::kRight}) {
      if (!scenario.lost(view, shot)) {
        const std::int64_t true_ns = shot * kPeriod;
        arrivals.push_back(
            {view,
             {static_cast<int>(arrivals.size()), scenario.first_sequence + shot, scenario.stamp(view, shot)},
             true_ns + scenario.latency(view, shot)});
      }
    }
  }
  std::stable_sort(arrivals.begin(), arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.at_ns < b.at_ns; });
  FrameSynchronizer synchronizer({.period_ns = kPeriod, .tolerance_ns = scenario.tolerance_ns});
  Outcome outcome;
  for (const Arrival& arrival : arrivals) {
    synchronizer.add(arrival.view, arrival.frame);
    while (const auto pair = synchronizer.next_pair()) {
      outcome.pairs.push_back(*pair);
    }
    while (const auto drop = synchronizer.next_drop()) {
      outcome.drops.push_back(*drop);
    }
  }
  outcome.counters = synchronizer.counters();
  outcome.offset_ms = static_cast<double>(synchronizer.offset_ns()) / 1e6;
  outcome.drift_ppm = synchronizer.drift() * 1e6;
  outcome.delivered = static_cast<int>(arrivals.size());

  // Invariants: each frame leaves at most once, almost none is kept, pairs advance in both views.
  std::vector<int> slots;
  for (const SyncPair& pair : outcome.pairs) {
    slots.push_back(pair.left.slot);
    slots.push_back(pair.right.slot);
  }
  for (const SyncDrop& drop : outcome.drops) {
    slots.push_back(drop.frame.slot);
  }
  std::sort(slots.begin(), slots.end());
  EXPECT_EQ(std::adjacent_find(slots.begin(), slots.end()), slots.end()) << "a frame left twice";
  EXPECT_GE(static_cast<int>(slots.size()), outcome.delivered - 2 * static_cast<int>(FrameSynchronizer::kWaiting));
  for (std::size_t i = 1; i < outcome.pairs.size(); ++i) {
    EXPECT_GT(outcome.pairs[i].left.sequence, outcome.pairs[i - 1].left.sequence);
    EXPECT_GT(outcome.pairs[i].right.sequence, outcome.pairs[i - 1].right.sequence);
  }
  EXPECT_EQ(outcome.counters.pairs, outcome.pairs.size());
  return outcome;
}

TEST(FrameSynchronizer, PairsEveryShotOfTwoPerfectCameras) {
  const Outcome outcome = play({});
  EXPECT_EQ(outcome.pairs.size(), 300U);
  EXPECT_EQ(outcome.wrong(), 0);
  EXPECT_TRUE(outcome.drops.empty());
}

TEST(FrameSynchronizer, NothingIsNothing) {
  EXPECT_TRUE(play({.shots = 0}).pairs.empty());
  EXPECT_EQ(play({.shots = 1}).pairs.size(), 1U);
}

TEST(FrameSynchronizer, ArrivalOrderSaysNothing) {
  // The right view's images take three periods longer: by arrival its partner would be another shot.
  const Outcome outcome = play({.latency = [](View view, int shot) {
    return view == View::kRight ? (shot % 2 == 0 ? 30 : 60) * kMs : 5 * kMs;
  }});
  EXPECT_EQ(outcome.wrong(), 0);
  EXPECT_GE(outcome.pairs.size(), 295U);
}

TEST(FrameSynchronizer, ToleratesJitterWithinTheTolerance) {
  std::mt19937 random(7);
  std::uniform_int_distribution<std::int64_t> jitter(-kTolerance / 2 + 1, kTolerance / 2 - 1);
  const Outcome outcome =
      play({.shots = 2000, .stamp = [&](View /*view*/, int shot) { return shot * kPeriod + jitter(random); }});
  EXPECT_GE(outcome.pairs.size(), 1990U);
  EXPECT_EQ(outcome.wrong(), 0);
  EXPECT_NEAR(outcome.offset_ms, 0.0, 1.0);
}

TEST(FrameSynchronizer, DropsOnlyTheOlderOfTwoThatDoNotFit) {
  // With a tolerance of half a period, two frames could make each other be dropped.
  for (const std::int64_t tolerance : {kTolerance, kPeriod / 2}) {
    const Outcome outcome = play({.shots = 200, .tolerance_ns = tolerance, .lost = [](View view, int shot) {
                                    return view == View::kLeft ? shot % 10 == 4 : shot % 10 == 7;
                                  }});
    EXPECT_EQ(outcome.pairs.size(), 160U) << "every shot that both views have";
    EXPECT_EQ(outcome.wrong(), 0);
    EXPECT_EQ(outcome.dropped(View::kLeft), 20);
    EXPECT_EQ(outcome.dropped(View::kRight), 20);
  }
}

TEST(FrameSynchronizer, FindsEveryCommonShotUnderRandomLosses) {
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U}) {
    std::mt19937 random(seed);
    std::bernoulli_distribution loses(0.3);
    std::vector<std::array<bool, 2>> lost(1000);
    int common = 0;
    for (auto& shot : lost) {
      shot = {loses(random), loses(random)};
      common += !shot[0] && !shot[1] ? 1 : 0;
    }
    const Outcome outcome = play({.shots = 1000, .lost = [&](View view, int shot) {
                                    return lost[static_cast<std::size_t>(shot)][static_cast<std::size_t>(view)];
                                  }});
    EXPECT_EQ(outcome.wrong(), 0);
    EXPECT_EQ(static_cast<int>(outcome.pairs.size()), common);
  }
}

TEST(FrameSynchronizer, LearnsAConstantOffsetWithinTheToleranceAndBeyond) {
  for (const std::int64_t offset_ms : {-16, -12, -5, -3, 3, 5, 12, 16}) {
    const Outcome outcome = play(
        {.stamp = [&](View view, int shot) { return shot * kPeriod + (view == View::kRight ? offset_ms * kMs : 0); }});
    EXPECT_EQ(outcome.wrong(), 0) << offset_ms;
    EXPECT_GE(outcome.pairs.size(), 290U) << offset_ms;
    EXPECT_NEAR(outcome.offset_ms, static_cast<double>(offset_ms), 0.1);
  }
}

TEST(FrameSynchronizer, AnOffsetOfHalfAPeriodIsOneOffsetUnderJitter) {
  std::mt19937 random(3);
  std::uniform_int_distribution<std::int64_t> jitter(-kMs, kMs);
  const Outcome outcome = play({.shots = 500, .stamp = [&](View view, int shot) {
                                  return shot * kPeriod + (view == View::kRight ? kPeriod / 2 : 0) + jitter(random);
                                }});
  EXPECT_GE(outcome.pairs.size(), 485U);
  // The partner among the neighbours is ambiguous, but it must not change.
  const std::int64_t lead = outcome.pairs.back().right.sequence - outcome.pairs.back().left.sequence;
  for (const SyncPair& pair : outcome.pairs) {
    EXPECT_EQ(pair.right.sequence - pair.left.sequence, lead);
  }
}

TEST(FrameSynchronizer, LearnsDrift) {
  // 50 ppm: 1.65 us a frame.
  const Outcome outcome = play({.shots = 3000, .stamp = [](View view, int shot) {
                                  return shot * kPeriod + (view == View::kRight ? shot * 1650 : 0);
                                }});
  EXPECT_EQ(outcome.pairs.size(), 3000U);
  EXPECT_EQ(outcome.wrong(), 0);
  EXPECT_NEAR(outcome.drift_ppm, 50.0, 5.0);
  EXPECT_NEAR(outcome.offset_ms, 3000 * 1650e-6, 0.1);
}

TEST(FrameSynchronizer, CamerasThatRunFreelyChangePartnersOnceAPeriod) {
  // 500 ppm: the right view falls behind by a period every 2000 shots, and so do its images.
  const auto behind_ns = [](View view, int shot) { return view == View::kRight ? shot * (kPeriod / 2000) : 0; };
  const Outcome outcome = play({.shots = 8000,
                                .stamp = [&](View view, int shot) { return shot * kPeriod + behind_ns(view, shot); },
                                .latency = [&](View view, int shot) { return 5 * kMs + behind_ns(view, shot); }});
  EXPECT_EQ(outcome.counters.slips, 4U);
  EXPECT_GE(outcome.pairs.size(), 7990U);
  EXPECT_LE(outcome.drops.size(), 8U);
  for (const SyncPair& pair : outcome.pairs) {
    EXPECT_LE(std::abs(pair.right.time_ns - pair.left.time_ns), kPeriod * 62 / 100);
  }
}

TEST(FrameSynchronizer, NeverEmitsAStaleFrame) {
  // Every fifth frame of the right view is the one before it, sent again under the next number.
  FrameSynchronizer synchronizer({.period_ns = kPeriod, .tolerance_ns = kTolerance});
  int pairs = 0;
  for (int shot = 0; shot < 100; ++shot) {
    const bool repeats = shot % 5 == 4;
    synchronizer.add(View::kLeft, {shot, shot, shot * kPeriod});
    synchronizer.add(View::kRight, {shot, shot, (repeats ? shot - 1 : shot) * kPeriod});
    while (const auto pair = synchronizer.next_pair()) {
      EXPECT_EQ(pair->left.time_ns, pair->right.time_ns);
      ++pairs;
    }
    while (const auto drop = synchronizer.next_drop()) {
      EXPECT_TRUE(drop->view == View::kLeft || drop->reason == SyncDrop::Reason::kStale);
    }
  }
  EXPECT_EQ(pairs, 80);
  EXPECT_EQ(synchronizer.counters().stale[1], 20U);
}

TEST(FrameSynchronizer, DropsAFrameThatComesOutOfOrder) {
  FrameSynchronizer synchronizer({.period_ns = kPeriod, .tolerance_ns = kTolerance});
  for (const int shot : {0, 1, 3, 2, 4}) {
    synchronizer.add(View::kLeft, {shot, shot, shot * kPeriod});
  }
  std::vector<std::int64_t> dropped;
  while (const auto drop = synchronizer.next_drop()) {
    dropped.push_back(drop->frame.sequence);
  }
  EXPECT_THAT(dropped, ::testing::UnorderedElementsAre(0, 1, 2));
}

TEST(FrameSynchronizer, HoldsNoMoreThanItSaysWhileOneCameraIsSilent) {
  const Outcome outcome = play(
      {.shots = 400, .lost = [](View view, int shot) { return view == View::kRight && shot >= 100 && shot < 300; }});
  EXPECT_EQ(outcome.pairs.size(), 200U) << "pairs continue as soon as the silent view is back";
  EXPECT_EQ(outcome.wrong(), 0);
  EXPECT_EQ(outcome.dropped(View::kLeft), 200);
  EXPECT_EQ(outcome.dropped(View::kRight), 0);
}

TEST(FrameSynchronizer, SurvivesJumpsOfOneClock) {
  for (const std::int64_t jump_ms : {-3'600'000, -5'000, -40, 40, 5'000, 3'600'000}) {
    const Outcome outcome = play({.shots = 400, .stamp = [&](View view, int shot) {
                                    return shot * kPeriod + (view == View::kRight && shot >= 200 ? jump_ms * kMs : 0);
                                  }});
    EXPECT_GE(outcome.pairs.size(), 370U) << jump_ms;
    if (std::abs(jump_ms) > FrameSynchronizer::kJumpPeriods * kPeriod / kMs) {
      EXPECT_EQ(outcome.wrong(), 0) << jump_ms;
    }
  }
}

TEST(FrameSynchronizer, SurvivesBothClocksGoingBackTogether) {
  const Outcome outcome = play({.shots = 400, .stamp = [](View /*view*/, int shot) {
                                  return shot * kPeriod - (shot >= 200 ? 50'000 * kMs : 0);
                                }});
  EXPECT_GE(outcome.pairs.size(), 390U);
  EXPECT_EQ(outcome.wrong(), 0);
}

TEST(FrameSynchronizer, BeginsAnewWhenAStreamCountsFromZeroAgain) {
  FrameSynchronizer synchronizer({.period_ns = kPeriod, .tolerance_ns = kTolerance});
  int pairs = 0;
  for (int shot = 0; shot < 200; ++shot) {
    // Both devices were reopened: numbers and, because their clocks rebooted, times restart.
    for (const View view : {View::kLeft, View::kRight}) {
      synchronizer.add(view, {shot, shot % 100, shot % 100 * kPeriod});
    }
    pairs += synchronizer.next_pair() ? 1 : 0;
    while (synchronizer.next_drop()) {
    }
  }
  EXPECT_GE(pairs, 195);
}

TEST(FrameSynchronizer, NumbersMayBeBeyond32Bits) {
  const Outcome outcome = play({.shots = 50, .first_sequence = (std::int64_t{1} << 32) - 25});
  EXPECT_EQ(outcome.pairs.size(), 50U);
}

TEST(FrameSynchronizer, ForgettingACameraDropsNothing) {
  FrameSynchronizer synchronizer({.period_ns = kPeriod, .tolerance_ns = kTolerance});
  synchronizer.add(View::kLeft, {0, 0, 0});
  synchronizer.add(View::kRight, {0, 0, kPeriod});
  synchronizer.forget(View::kLeft);
  EXPECT_FALSE(synchronizer.next_pair());
  EXPECT_FALSE(synchronizer.next_drop());
  synchronizer.add(View::kLeft, {1, 0, kPeriod});
  EXPECT_TRUE(synchronizer.next_pair()) << "the other view still waits";
}

TEST(FrameSynchronizer, TwoCamerasOfDifferentRatesPairWhereTheyMeet) {
  const Outcome outcome =
      play({.shots = 300, .lost = [](View view, int shot) { return view == View::kRight && shot % 2 == 1; }});
  EXPECT_EQ(outcome.pairs.size(), 150U);
  EXPECT_EQ(outcome.wrong(), 0);
}

TEST(SyncConfig, ToleranceIsAtMostHalfAPeriod) {
  EXPECT_TRUE((SyncConfig{.period_ns = 10, .tolerance_ns = 5}).validate());
  EXPECT_FALSE((SyncConfig{.period_ns = 10, .tolerance_ns = 6}).validate());
  EXPECT_FALSE((SyncConfig{.period_ns = 10, .tolerance_ns = 0}).validate());
  EXPECT_FALSE((SyncConfig{.period_ns = 0, .tolerance_ns = 1}).validate());
}

}  // namespace
}  // namespace kinetrace::hal

#include "kinetrace/publishing/result_mailbox.hpp"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sample_results.hpp"

namespace kinetrace::publishing {
namespace {

using test::SampleResult;
using testing::ElementsAre;

struct Mailbox {
  explicit Mailbox(PublishConfig given = {}) : config(std::move(given)), arena(ResultMailbox::required_bytes(config)) {
    auto made = ResultMailbox::create(config, arena);
    EXPECT_TRUE(made) << made.error().message;
    mailbox = std::move(*made);
  }
  std::vector<TrajectoryEvent> events() {
    std::vector<TrajectoryEvent> all;
    for (TrajectoryEvent event; mailbox->fetch(event);) {
      all.push_back(event);
    }
    return all;
  }
  PublishConfig config;
  Arena arena;
  std::unique_ptr<ResultMailbox> mailbox;
};

TEST(ResultMailbox, TakesExactlyWhatItAsksFor) {
  const PublishConfig config;
  Arena small(ResultMailbox::required_bytes(config) - 1);
  const auto refused = ResultMailbox::create(config, small);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kCapacity);
  const Mailbox fits;
}

TEST(ResultMailbox, GivesOutTheNewestFrameOnce) {
  Mailbox box;
  EXPECT_EQ(box.mailbox->fetch_frame(), nullptr);
  for (std::int64_t frame = 0; frame < 3; ++frame) {
    box.mailbox->offer(SampleResult({}, frame).result, 5);
  }
  const PublishedFrame* newest = box.mailbox->fetch_frame();
  ASSERT_NE(newest, nullptr);
  EXPECT_EQ(newest->frame_index, 2);
  EXPECT_EQ(newest->objects.size(), 2U);
  EXPECT_EQ(box.mailbox->fetch_frame(), nullptr);
  EXPECT_EQ(box.mailbox->counters().offered, 3U);
  EXPECT_EQ(box.mailbox->counters().superseded, 2U);
}

TEST(ResultMailbox, FinalisedPosesAreNotSuperseded) {
  Mailbox box;
  for (std::int64_t frame = 0; frame < 5; ++frame) {
    box.mailbox->offer(SampleResult({.objects = 2}, frame).result, 5);
  }
  const std::vector<TrajectoryEvent> events = box.events();
  ASSERT_EQ(events.size(), 10U);
  EXPECT_EQ(events[8].frame_index, 4);
  EXPECT_EQ(events[8].track_id, 1U);
  EXPECT_EQ(events[9].track_id, 2U);
  EXPECT_FALSE(events[9].ends);
}

TEST(ResultMailbox, PosesBeyondTheQueueAreCounted) {
  PublishConfig config;
  config.trajectory_queue = 64;
  Mailbox box(config);
  for (std::int64_t frame = 0; frame < 65; ++frame) {
    box.mailbox->offer(SampleResult({.objects = 1}, frame).result, 5);
  }
  EXPECT_EQ(box.mailbox->counters().trajectory_poses_dropped, 1U);
  EXPECT_EQ(box.events().size(), 64U);
}

// A result whose finalised frame lags by `lag`; `alive` bodies are in the newest frame, `finalised` objects in the old
// one.
void offer(ResultMailbox& mailbox, std::int64_t frame, std::int64_t lag, int alive, int finalised) {
  SampleResult newest({.objects = alive}, frame);
  const SampleResult old({.objects = finalised}, frame - lag);
  newest.result.finalised = old.result.newest;
  mailbox.offer(newest.result, 5);
}

TEST(ResultMailbox, ATrajectoryEndsWhenItsLastFrameHasFinalised) {
  Mailbox box;
  offer(*box.mailbox, 10, 3, 1, 1);
  offer(*box.mailbox, 11, 3, 0, 1);  // Its track has ended; frames up to 10 may hold it.
  offer(*box.mailbox, 12, 3, 0, 0);  // Unseen for a frame.
  EXPECT_EQ(box.events().size(), 2U) << "poses of frames 7 and 8, no end yet";
  offer(*box.mailbox, 13, 3, 0, 1);
  const std::vector<TrajectoryEvent> last = box.events();
  ASSERT_EQ(last.size(), 2U);
  EXPECT_EQ(last[0].frame_index, 10);
  EXPECT_TRUE(last[1].ends);
  EXPECT_EQ(last[1].track_id, 1U);
  offer(*box.mailbox, 14, 3, 0, 0);
  EXPECT_TRUE(box.events().empty()) << "it ends once";
}

TEST(ResultMailbox, WhatIsHiddenForAWhileDoesNotEnd) {
  Mailbox box;
  offer(*box.mailbox, 10, 3, 1, 1);
  for (std::int64_t frame = 11; frame < 40; ++frame) {
    offer(*box.mailbox, frame, 3, 1, 0);
  }
  const std::vector<TrajectoryEvent> events = box.events();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_FALSE(events[0].ends);
}

TEST(ResultMailbox, EverythingEndsWithTheRun) {
  Mailbox box;
  offer(*box.mailbox, 10, 3, 3, 3);
  box.mailbox->end_trajectories();
  box.mailbox->end_trajectories();
  std::vector<std::uint32_t> ended;
  for (const TrajectoryEvent& event : box.events()) {
    if (event.ends) {
      ended.push_back(event.track_id);
    }
  }
  EXPECT_THAT(ended, ElementsAre(1U, 2U, 3U));
}

TEST(ResultMailbox, HealthIsTheNewestToo) {
  Mailbox box;
  EXPECT_EQ(box.mailbox->fetch_health(), nullptr);
  PublishedHealth health;
  health.frame_index = 3;
  box.mailbox->offer_health(health);
  health.frame_index = 4;
  box.mailbox->offer_health(health);
  const PublishedHealth* newest = box.mailbox->fetch_health();
  ASSERT_NE(newest, nullptr);
  EXPECT_EQ(newest->frame_index, 4);
}

}  // namespace
}  // namespace kinetrace::publishing

// Masks between two threads: acceptance, storage, waiting and counting.
#include "segmentation/mask_mailbox.hpp"

#include <memory>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::app {
namespace {

using std::chrono::milliseconds;

constexpr std::uint32_t kWidth = 100;
constexpr std::uint32_t kHeight = 50;
constexpr std::uint64_t kHonest = 17;
constexpr std::uint64_t kOther = 18;

constexpr std::int64_t time_of(std::int64_t frame) {
  return 1000 + 100 * frame;
}

/// A message with masks of one pixel each.
struct Sent {
  std::vector<std::uint16_t> runs{0, 1};
  std::vector<RunLengthMask> masks;
  MaskMessage message;

  explicit Sent(std::int64_t frame, std::size_t count = 1, View view = View::kLeft, std::uint32_t piece = 0,
                std::uint32_t pieces = 1)
      : masks(count, {kVehicleClass, 1.F, {3, 4, 4, 5}, runs}),
        message{.sender = kHonest,
                .frame_index = frame,
                .timestamp_ns = time_of(frame),
                .view = view,
                .width_px = kWidth,
                .height_px = kHeight,
                .piece = piece,
                .pieces = pieces,
                .masks = masks} {}
  Sent(const Sent&) = delete;
  Sent& operator=(const Sent&) = delete;
  Sent(Sent&&) noexcept = default;

  Sent& from(std::uint64_t sender) {
    message.sender = sender;
    return *this;
  }
  Sent& at(std::int64_t timestamp_ns) {
    message.timestamp_ns = timestamp_ns;
    return *this;
  }
  /// Images of another size than requested.
  Sent& damaged() {
    message.width_px = kWidth + 1;
    return *this;
  }
};

class MaskMailboxTest : public ::testing::Test {
 protected:
  MaskMailbox& make(bool right = false, milliseconds timeout = milliseconds(5)) {
    const MaskMailboxConfig config{kWidth, kHeight, right, timeout};
    arena_ = std::make_unique<Arena>(MaskMailbox::required_bytes(config));
    mailbox_ = std::make_unique<MaskMailbox>(config, *arena_);
    EXPECT_FALSE(arena_->exhausted());
    mailbox_->set_senders(1);
    return *mailbox_;
  }
  static void request(MaskMailbox& mailbox, std::int64_t frame) {
    RectifiedPair pair;
    pair.frame_index = frame;
    pair.timestamp_ns = time_of(frame);
    mailbox.request(pair);
  }
  static const MaskSet* take(MaskMailbox& mailbox, std::int64_t frame) {
    request(mailbox, frame);
    return mailbox.await(frame);
  }

  std::unique_ptr<Arena> arena_;
  std::unique_ptr<MaskMailbox> mailbox_;
};

TEST_F(MaskMailboxTest, GivesWhatWasOffered) {
  MaskMailbox& mailbox = make();
  Sent sent(7, 2);
  sent.masks[1] = {kPedestrianClass, 0.5F, {0, 0, 1, 1}, sent.runs};
  mailbox.offer(sent.message);
  sent.runs.assign({9, 9});  // The mailbox has copies.
  const MaskSet* masks = take(mailbox, 7);
  ASSERT_NE(masks, nullptr);
  ASSERT_EQ(masks->left.size(), 2U);
  EXPECT_EQ(masks->left[0].box_px.x0, 3);
  EXPECT_THAT(masks->left[0].runs, ::testing::ElementsAre(0, 1));
  EXPECT_EQ(masks->left[1].class_id, kPedestrianClass);
  EXPECT_EQ(masks->left[1].score, 0.5F);
  EXPECT_EQ(mailbox.counters().frames_taken, 1U);
}

TEST_F(MaskMailboxTest, NoMasksAreAnAnswerToo) {
  MaskMailbox& mailbox = make();
  mailbox.offer(Sent(7, 0).message);
  const MaskSet* masks = take(mailbox, 7);
  ASSERT_NE(masks, nullptr);
  EXPECT_TRUE(masks->left.empty());
}

TEST_F(MaskMailboxTest, WaitsForWhatComesInTime) {
  MaskMailbox& mailbox = make(false, milliseconds(10'000));
  request(mailbox, 7);
  std::thread network([&mailbox] {
    std::this_thread::sleep_for(milliseconds(30));
    mailbox.offer(Sent(7).message);
  });
  EXPECT_NE(mailbox.await(7), nullptr);
  network.join();
}

TEST_F(MaskMailboxTest, GivesUpAfterTheTimeout) {
  MaskMailbox& mailbox = make(false, milliseconds(40));
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(take(mailbox, 7), nullptr);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, milliseconds(40));
  EXPECT_EQ(mailbox.counters().frames_timed_out, 1U);
  EXPECT_EQ(mailbox.counters().frames_unsent, 0U);
}

TEST_F(MaskMailboxTest, DoesNotWaitWithoutASender) {
  MaskMailbox& mailbox = make(false, milliseconds(10'000));
  mailbox.set_senders(0);
  EXPECT_EQ(take(mailbox, 7), nullptr);
  EXPECT_EQ(mailbox.counters().frames_unsent, 1U);
  EXPECT_FALSE(mailbox.wait_for_sender(milliseconds(1)));
  mailbox.set_senders(1);
  EXPECT_TRUE(mailbox.wait_for_sender(milliseconds(1)));
}

TEST_F(MaskMailboxTest, StopsWaitingForASenderThatGoes) {
  MaskMailbox& mailbox = make(false, milliseconds(10'000));
  request(mailbox, 7);
  std::thread network([&mailbox] {
    std::this_thread::sleep_for(milliseconds(30));
    mailbox.set_senders(0);
  });
  EXPECT_EQ(mailbox.await(7), nullptr);
  network.join();
}

TEST_F(MaskMailboxTest, WantsAllPiecesInAnyOrderEachOnce) {
  MaskMailbox& mailbox = make();
  mailbox.offer(Sent(7, 2, View::kLeft, 1, 3).message);
  mailbox.offer(Sent(7, 2, View::kLeft, 1, 3).message);
  mailbox.offer(Sent(7, 1, View::kLeft, 0, 3).message);
  EXPECT_EQ(take(mailbox, 7), nullptr) << "the third piece is missing";
  mailbox.offer(Sent(7, 1, View::kLeft, 2, 3).message);
  const MaskSet* masks = mailbox.await(7);
  ASSERT_NE(masks, nullptr);
  EXPECT_EQ(masks->left.size(), 4U);
}

TEST_F(MaskMailboxTest, AsManyPiecesAsThereMayBeAndNotOneMore) {
  MaskMailbox& mailbox = make();
  for (std::uint32_t piece = 0; piece < MaskMailbox::kMaxPieces; ++piece) {
    mailbox.offer(Sent(7, 1, View::kLeft, piece, MaskMailbox::kMaxPieces).message);
  }
  EXPECT_NE(take(mailbox, 7), nullptr);
  mailbox.offer(Sent(8, 1, View::kLeft, 0, MaskMailbox::kMaxPieces + 1).message);
  EXPECT_EQ(take(mailbox, 8), nullptr);
  EXPECT_EQ(mailbox.counters().messages_invalid, 1U);
}

TEST_F(MaskMailboxTest, WantsBothCamerasWhereBothAreAskedFor) {
  MaskMailbox& mailbox = make(true);
  mailbox.offer(Sent(7, 1, View::kLeft).message);
  EXPECT_EQ(take(mailbox, 7), nullptr);
  mailbox.offer(Sent(7, 2, View::kRight).message);
  const MaskSet* masks = mailbox.await(7);
  ASSERT_NE(masks, nullptr);
  EXPECT_EQ(masks->left.size(), 1U);
  EXPECT_EQ(masks->right.size(), 2U);
}

TEST_F(MaskMailboxTest, DropsAndCountsWhatComesLate) {
  MaskMailbox& mailbox = make();
  request(mailbox, 8);
  mailbox.offer(Sent(7).message);
  EXPECT_EQ(mailbox.counters().messages_late, 1U);
  EXPECT_EQ(mailbox.await(8), nullptr);
}

TEST_F(MaskMailboxTest, HasRoomForTheFrameThatIsWaitedForWhateverIsAheadOfIt) {
  MaskMailbox& mailbox = make();
  request(mailbox, 5);
  for (std::int64_t frame = 100; frame <= 100 + std::int64_t{MaskMailbox::kFrames}; ++frame) {
    mailbox.offer(Sent(frame).message);
  }
  EXPECT_EQ(mailbox.counters().messages_early, 1U);
  // Replaces the message farthest ahead.
  mailbox.offer(Sent(5).message);
  EXPECT_EQ(mailbox.counters().messages_early, 2U);
  EXPECT_NE(mailbox.await(5), nullptr);
  // Frames that the pipeline leaves out make room.
  EXPECT_NE(take(mailbox, 102), nullptr);
  mailbox.offer(Sent(103).message);
  mailbox.offer(Sent(104).message);
  EXPECT_EQ(mailbox.counters().messages_early, 2U);
  EXPECT_NE(take(mailbox, 104), nullptr);
}

TEST_F(MaskMailboxTest, LeavesAloneWhatThePipelineReads) {
  MaskMailbox& mailbox = make();
  mailbox.offer(Sent(7).message);
  const MaskSet* masks = take(mailbox, 7);
  ASSERT_NE(masks, nullptr);
  for (std::int64_t frame = 7; frame < 20; ++frame) {
    Sent other(frame, 3);
    other.runs.assign({1, 0});
    mailbox.offer(other.message);
  }
  ASSERT_EQ(masks->left.size(), 1U);
  EXPECT_THAT(masks->left[0].runs, ::testing::ElementsAre(0, 1));
}

TEST_F(MaskMailboxTest, RefusesFramesWithAnythingWrong) {
  const auto is_refused = [this](auto&& damage) {
    MaskMailbox& mailbox = make(false, milliseconds(10'000));
    Sent sent(7, 2);
    damage(sent);
    mailbox.offer(sent.message);
    // Decided at once, long before the time-out.
    return take(mailbox, 7) == nullptr && mailbox.counters().messages_invalid == 1;
  };
  EXPECT_FALSE(is_refused([](Sent&) {}));
  EXPECT_TRUE(is_refused([](Sent& s) { s.message.width_px = kWidth + 1; }));
  EXPECT_TRUE(is_refused([](Sent& s) { s.message.height_px = kHeight - 1; }));
  EXPECT_TRUE(is_refused([](Sent& s) { s.message.view = View::kRight; })) << "not asked for";
  EXPECT_TRUE(is_refused([](Sent& s) { s.message.pieces = 0; }));
  EXPECT_TRUE(is_refused([](Sent& s) { s.message.piece = 1; })) << "of one";
  EXPECT_TRUE(is_refused([](Sent& s) { s.runs.assign({1, 1}); })) << "two pixels in a box of one";
  EXPECT_TRUE(is_refused([](Sent& s) { s.masks[1].box_px.x1 = 101; }));
}

TEST_F(MaskMailboxTest, ASenderSpoilsNothingButItsOwn) {
  MaskMailbox& mailbox = make(false, milliseconds(10'000));
  mailbox.set_senders(2);
  request(mailbox, 7);
  mailbox.offer(Sent(7, 1, View::kLeft, 0, 2).message);
  mailbox.offer(Sent(7).from(kOther).damaged().message);
  mailbox.offer(Sent(7, 1, View::kLeft, 1, 2).message);
  const MaskSet* masks = mailbox.await(7);
  ASSERT_NE(masks, nullptr);
  EXPECT_EQ(masks->left.size(), 2U);
  EXPECT_EQ(mailbox.counters().messages_invalid, 1U);
}

TEST_F(MaskMailboxTest, PutsTogetherWhatOneSenderHasSent) {
  MaskMailbox& mailbox = make();
  mailbox.set_senders(2);
  mailbox.offer(Sent(7, 1, View::kLeft, 0, 2).message);
  mailbox.offer(Sent(7, 5, View::kLeft, 1, 2).from(kOther).message);
  EXPECT_EQ(take(mailbox, 7), nullptr) << "half of each";
  mailbox.offer(Sent(7, 2, View::kLeft, 1, 2).message);
  const MaskSet* masks = mailbox.await(7);
  ASSERT_NE(masks, nullptr);
  EXPECT_EQ(masks->left.size(), 3U);
}

TEST_F(MaskMailboxTest, SendersOfBadMessagesLeaveRoomHoweverMany) {
  MaskMailbox& mailbox = make();
  mailbox.set_senders(100);
  request(mailbox, 7);
  for (std::uint64_t sender = 0; sender < 3 * MaskMailbox::kFrames; ++sender) {
    mailbox.offer(Sent(7).from(100 + sender).damaged().message);
  }
  mailbox.offer(Sent(7).message);
  EXPECT_NE(mailbox.await(7), nullptr);
  EXPECT_EQ(mailbox.counters().messages_invalid, 3 * MaskMailbox::kFrames);
}

TEST_F(MaskMailboxTest, RefusesMasksOfAnotherTimeThanTheFrameTheyName) {
  MaskMailbox& mailbox = make();
  request(mailbox, 7);
  mailbox.offer(Sent(7).at(0).message);
  mailbox.offer(Sent(7).from(kOther).at(time_of(7) + 1).message);
  EXPECT_EQ(mailbox.await(7), nullptr);
  EXPECT_EQ(mailbox.counters().messages_of_other_run, 2U);
  EXPECT_EQ(mailbox.counters().messages_invalid, 0U);
  mailbox.offer(Sent(7, 3).message);
  const MaskSet* masks = mailbox.await(7);
  ASSERT_NE(masks, nullptr);
  EXPECT_EQ(masks->left.size(), 3U);
}

TEST_F(MaskMailboxTest, RefusesMasksOfAnotherTimeThatCameBeforeTheyWereAskedFor) {
  MaskMailbox& mailbox = make();
  // One sender that answers two runs.
  mailbox.offer(Sent(7, 1, View::kLeft, 0, 2).at(0).message);
  mailbox.offer(Sent(7, 1, View::kLeft, 1, 2).at(0).message);
  mailbox.offer(Sent(7, 3).message);
  const MaskSet* masks = take(mailbox, 7);
  ASSERT_NE(masks, nullptr);
  EXPECT_EQ(masks->left.size(), 3U);
  EXPECT_EQ(mailbox.counters().messages_of_other_run, 2U);
}

TEST_F(MaskMailboxTest, RefusesAFrameWhosePiecesContradictEachOther) {
  MaskMailbox& mailbox = make();
  mailbox.offer(Sent(7, 1, View::kLeft, 0, 2).message);
  mailbox.offer(Sent(7, 1, View::kLeft, 1, 3).message);
  EXPECT_EQ(take(mailbox, 7), nullptr);
  EXPECT_EQ(mailbox.counters().messages_invalid, 1U);
}

TEST_F(MaskMailboxTest, HoldsAsManyMasksAndRunsAsItSaysAndNotOneMore) {
  MaskMailbox& mailbox = make();
  mailbox.offer(Sent(7, MaskMailbox::kMaxMasks).message);
  EXPECT_NE(take(mailbox, 7), nullptr);
  mailbox.offer(Sent(8, MaskMailbox::kMaxMasks + 1).message);
  EXPECT_EQ(take(mailbox, 8), nullptr);

  const auto with_runs = [](std::int64_t frame, std::size_t count) {
    Sent sent(frame, 1);
    sent.runs.assign(count, 0);
    sent.runs.back() = 1;
    sent.masks[0].runs = sent.runs;
    return sent;
  };
  mailbox.offer(with_runs(9, MaskMailbox::kMaxRuns).message);
  EXPECT_NE(take(mailbox, 9), nullptr);
  mailbox.offer(with_runs(10, MaskMailbox::kMaxRuns + 1).message);
  EXPECT_EQ(take(mailbox, 10), nullptr);
  EXPECT_EQ(mailbox.counters().messages_invalid, 2U);
}

TEST_F(MaskMailboxTest, HandsOutTheNewestRequestOnce) {
  MaskMailbox& mailbox = make(true);
  int asked = 0;
  mailbox.on_request([&asked] { ++asked; });
  EXPECT_FALSE(mailbox.take_request());
  request(mailbox, 7);
  request(mailbox, 8);
  EXPECT_EQ(asked, 2);
  const std::optional<MaskRequest> newest = mailbox.take_request();
  ASSERT_TRUE(newest);
  EXPECT_EQ(newest->frame_index, 8);
  EXPECT_EQ(newest->width_px, kWidth);
  EXPECT_TRUE(newest->right);
  EXPECT_FALSE(mailbox.take_request());
}

}  // namespace
}  // namespace kinetrace::app

#include "kinetrace/hal/frame_guard.hpp"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scripted_camera.hpp"

namespace kinetrace::hal::test {
namespace {

using ::testing::ElementsAre;

// The scripted camera never waits, so that this is never reached.
constexpr std::chrono::milliseconds kTimeout{10'000};

class Guarded : public ::testing::Test {
 protected:
  void begin(bool mend_times = true) {
    guard_.emplace(std::move(made_), FrameGuardConfig{.mend_times = mend_times});
    ASSERT_TRUE(guard_->open() && guard_->start());
  }
  /// Plays to the end.
  void play(bool mend_times = true) {
    begin(mend_times);
    for (;;) {
      const Result<StereoFrame> frame = guard_->next(kTimeout);
      if (!frame) {
        EXPECT_EQ(frame.error().code, ErrorCode::kEndOfStream);
        break;
      }
      indices_.push_back(frame->frame_index);
      times_.push_back(frame->timestamp_ns / ScriptedCamera::kPeriod_ns);
    }
  }

  std::unique_ptr<ScriptedCamera> made_ = std::make_unique<ScriptedCamera>();
  ScriptedCamera& camera_ = *made_;
  std::optional<FrameGuard> guard_;
  std::vector<std::int64_t> indices_;
  std::vector<std::int64_t> times_;  ///< In periods.
};

TEST_F(Guarded, PassesGoodFramesUnchanged) {
  camera_.give_frames(5, 8);
  camera_.give_frames(12, 13);
  play();
  EXPECT_THAT(indices_, ElementsAre(5, 6, 7, 8, 12, 13));
  EXPECT_THAT(times_, ElementsAre(5, 6, 7, 8, 12, 13));
  EXPECT_EQ(guard_->counters().frames_delivered, 6U);
  EXPECT_EQ(guard_->counters().clock_jumps, 0U);
}

TEST_F(Guarded, SkipsWhatCameBefore) {
  for (const int index : {0, 1, 1, 3, 2, 4}) {
    camera_.give(camera_.frame(index));
  }
  play();
  EXPECT_THAT(indices_, ElementsAre(0, 1, 3, 4));
  EXPECT_EQ(guard_->counters().skipped_repeated, 2U);
  EXPECT_EQ(guard_->counters().frames_delivered, 4U);
}

TEST_F(Guarded, SkipsAnotherSize) {
  camera_.give_frames(0, 0);
  StereoFrame small = camera_.frame(1);
  small.right.height /= 2;
  camera_.give(small);
  camera_.give_frames(2, 2);
  play();
  EXPECT_THAT(indices_, ElementsAre(0, 2));
  EXPECT_EQ(guard_->counters().skipped_wrong_size, 1U);
}

TEST_F(Guarded, SkipsAnImageThatWasCutOff) {
  std::vector<std::uint8_t> pixels(ScriptedCamera::kWidth * ScriptedCamera::kHeight, 0);
  const StereoFrame whole = camera_.frame(1);
  std::copy_n(whole.left.data, pixels.size() / 2, pixels.begin());
  StereoFrame cut = whole;
  cut.right.data = pixels.data();
  StereoFrame dark = camera_.frame(3);
  dark.left.data = dark.right.data = pixels.data();
  camera_.give_frames(0, 0);
  camera_.give(cut);
  camera_.give_frames(2, 2);
  camera_.give(dark);
  play();
  EXPECT_THAT(indices_, ElementsAre(0, 2, 3)) << "what both views see is no damage";
  EXPECT_EQ(guard_->counters().skipped_unreadable, 1U);
}

TEST_F(Guarded, TheEndOfAStreamThatWasOfNoUseNamesTheFirstImage) {
  const std::vector<std::uint8_t> black(ScriptedCamera::kWidth * ScriptedCamera::kHeight, 0);
  for (const std::int64_t index : {7, 8}) {
    StereoFrame frame = camera_.frame(index);
    frame.left.data = black.data();
    camera_.give(frame);
  }
  begin(false);
  const Result<StereoFrame> end = guard_->next(kTimeout);
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().code, ErrorCode::kBadFormat);
  EXPECT_THAT(
      end.error().message,
      ::testing::HasSubstr("the first: scripted: left image of frame 7: its lower 48 of 48 rows are of one value"));
}

TEST_F(Guarded, TakesNeitherSkyNorNightForDamage) {
  const StereoFrame whole = camera_.frame(0);
  // A third and more of one view of one value, the other view with a little noise.
  for (const int value : {0, 252}) {
    for (const bool is_lower : {false, true}) {
      std::vector<std::uint8_t> flat(whole.left.data,
                                     whole.left.data + ScriptedCamera::kWidth * ScriptedCamera::kHeight);
      std::vector<std::uint8_t> noisy = flat;
      const std::size_t first = is_lower ? flat.size() / 2 : 0;
      for (std::size_t i = first; i < first + flat.size() / 2; ++i) {
        flat[i] = static_cast<std::uint8_t>(value);
        noisy[i] = static_cast<std::uint8_t>(value + static_cast<int>(i % 4));
      }
      StereoFrame frame = whole;
      frame.left.data = flat.data();
      frame.right.data = noisy.data();
      EXPECT_FALSE(CutOffDetector().examine(frame)) << value << is_lower;
    }
  }
  // Nor is a uniform sky in one view alone: a cut-off image lacks its end.
  std::vector<std::uint8_t> sky(whole.left.data, whole.left.data + ScriptedCamera::kWidth * ScriptedCamera::kHeight);
  std::fill_n(sky.begin(), sky.size() / 2, std::uint8_t{255});
  StereoFrame frame = whole;
  frame.right.data = sky.data();
  EXPECT_FALSE(CutOffDetector().examine(frame));
}

TEST_F(Guarded, MendsTimesByTheFrameNumbers) {
  camera_.give_frames(0, 2);
  for (const int index : {3, 5, 6}) {
    StereoFrame frame = camera_.frame(index);
    frame.timestamp_ns -= 3'600'000'000'000;
    camera_.give(frame);
  }
  camera_.give_frames(7, 8);
  play();
  EXPECT_THAT(indices_, ElementsAre(0, 1, 2, 3, 5, 6, 7, 8));
  EXPECT_THAT(times_, ElementsAre(0, 1, 2, 3, 5, 6, 7, 8));
  EXPECT_EQ(guard_->counters().clock_jumps, 2U);
}

TEST_F(Guarded, ACameraFasterThanAnnouncedKeepsItsTimes) {
  for (int i = 0; i < 12; ++i) {
    StereoFrame frame = camera_.frame(i);
    frame.timestamp_ns = i * ScriptedCamera::kPeriod_ns / 4;
    camera_.give(frame);
  }
  play();
  EXPECT_THAT(times_, ElementsAre(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2));
  EXPECT_EQ(guard_->counters().clock_jumps, 0U);
}

TEST_F(Guarded, AcceptsTheTimesOfARecordingAslongAsTheyAdvance) {
  camera_.give_frames(0, 1);
  for (const std::int64_t late_s : {60, 60, -5}) {
    StereoFrame frame = camera_.frame(2 + static_cast<std::int64_t>(indices_.size()));
    indices_.push_back(0);
    frame.timestamp_ns += late_s * 1'000'000'000;
    camera_.give(frame);
  }
  indices_.clear();
  play(false);
  EXPECT_THAT(times_, ElementsAre(0, 1, 602, 603)) << "a pause is a pause";
  EXPECT_EQ(guard_->counters().skipped_repeated, 1U);
  EXPECT_EQ(guard_->counters().clock_jumps, 0U);
}

TEST_F(Guarded, PassesErrorsOnAndGivesUpOnNothingButRubbish) {
  camera_.give(fail(ErrorCode::kDisconnected, "gone"));
  camera_.give_frames(0, 0);
  for (int i = 0; i < 100; ++i) {
    camera_.give(camera_.frame(0));
  }
  begin();
  EXPECT_EQ(guard_->next(kTimeout).error().code, ErrorCode::kDisconnected);
  EXPECT_TRUE(guard_->next(kTimeout));
  const Result<StereoFrame> rubbish = guard_->next(kTimeout);
  EXPECT_EQ(rubbish.error().code, ErrorCode::kTimeout) << "or a camera that only repeats itself would hold us for ever";
}

TEST_F(Guarded, NeverTakesLongerThanItMay) {
  camera_.frame_takes = std::chrono::milliseconds(5);
  for (int i = 0; i < 30; ++i) {
    camera_.give(camera_.frame(0));
  }
  camera_.give_frames(1, 1);
  begin();
  ASSERT_TRUE(guard_->next(kTimeout));
  EXPECT_EQ(guard_->next(std::chrono::milliseconds(30)).error().code, ErrorCode::kTimeout)
      << "the next good frame is 150 ms away";
}

TEST_F(Guarded, CountersBeginAnewWithEachStart) {
  camera_.give_frames(0, 0);
  camera_.give_frames(0, 0);
  play();
  EXPECT_EQ(guard_->counters().skipped_repeated, 1U);
  ASSERT_TRUE(guard_->stop() && guard_->start());
  EXPECT_EQ(guard_->counters().skipped_repeated, 0U);
  camera_.give_frames(0, 0);
  EXPECT_TRUE(guard_->next(kTimeout));
}

}  // namespace
}  // namespace kinetrace::hal::test

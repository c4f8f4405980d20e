#include "kinetrace/hal/file_stereo_camera.hpp"

#include <filesystem>
#include <sys/stat.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "recording_for_test.hpp"

namespace kinetrace::hal {
namespace {

using ::testing::HasSubstr;

constexpr std::chrono::milliseconds kTimeout{100};

// A camera on a recording, streaming.
struct Playing {
  explicit Playing(const Dataset& dataset, FileCameraConfig config = {})
      : arena(FileStereoCamera::required_bytes(dataset, config)),
        camera(FileStereoCamera::create(dataset, config, arena).value()) {
    EXPECT_TRUE(camera.open());
    EXPECT_TRUE(camera.start());
  }
  Arena arena;
  FileStereoCamera camera;
};

TEST(FileStereoCamera, DeliversEveryPairInOrder) {
  const test::Recording recording(3);
  Playing playing(recording.open().value());
  for (int i = 0; i < 3; ++i) {
    const auto frame = playing.camera.next(kTimeout);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->frame_index, i);
    EXPECT_EQ(frame->timestamp_ns, i * 100'000'000);
    EXPECT_EQ(frame->name, "00000" + std::to_string(i));
    EXPECT_EQ(frame->left.at(test::kWidth - 1, test::kHeight - 1), i);
    EXPECT_EQ(frame->right.at(0, 0), 100 + i);
  }
  const auto end = playing.camera.next(kTimeout);
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().code, ErrorCode::kEndOfStream);
  EXPECT_EQ(playing.camera.counters().frames_delivered, 3U);
  EXPECT_EQ(playing.camera.info().frame_count, 3);
  EXPECT_EQ(playing.camera.info().width_px, test::kWidth);
  EXPECT_EQ(playing.camera.info().name, "sequence");
}

TEST(FileStereoCamera, ValuesOfTwelveBitsInSixteenAreBrightAsTheyWere) {
  const test::Recording recording(20);
  for (int i = 0; i < 20; ++i) {
    // One of them is bright, the others are dark.
    test::write_image16(recording.left(i), static_cast<std::uint16_t>(i == 10 ? 4000 : 160));
    test::write_image16(recording.right(i), 320);
  }
  const Dataset dataset = recording.open().value();
  EXPECT_EQ(dataset.sample_bits, 12);
  EXPECT_THAT(dataset.notes, ::testing::Contains(HasSubstr("image_0: the images hold values of 12 bits in 16")));
  Playing playing(dataset);
  const auto frame = playing.camera.next(kTimeout);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->left.at(0, 0), 160 >> 4);
  EXPECT_EQ(frame->right.at(0, 0), 320 >> 4);
}

TEST(FileStereoCamera, ValuesOfSixteenBitsKeepTheirUpperByte) {
  const test::Recording recording(2);
  test::write_image16(recording.left(0), 160);
  test::write_image16(recording.right(0), 160);
  test::write_image16(recording.left(1), 50000);
  test::write_image16(recording.right(1), 50000);
  const Dataset dataset = recording.open().value();
  EXPECT_EQ(dataset.sample_bits, 16);
  EXPECT_THAT(dataset.notes, ::testing::Not(::testing::Contains(HasSubstr("bits in 16"))));
}

TEST(FileStereoCamera, ViewsOfDifferentBitDepthsAreANote) {
  const test::Recording recording(2);
  for (int i = 0; i < 2; ++i) {
    test::write_image16(recording.left(i), 4000);
  }
  // The right images have 8 bits.
  const Dataset own = recording.open().value();
  EXPECT_EQ(own.sample_bits, 12) << "of the left images alone";
  EXPECT_THAT(own.notes, ::testing::Contains(HasSubstr("image_0: the left images hold values of 12 bits in 16, the "
                                                       "right ones of the whole range of their format; each view is "
                                                       "scaled by its own bit depth")));
  Playing playing(own);
  const auto frame = playing.camera.next(kTimeout);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->left.at(0, 0), 4000 >> 4);
  EXPECT_EQ(frame->right.at(0, 0), 100);
  for (int i = 0; i < 2; ++i) {
    test::write_image16(recording.right(i), 64000);
  }
  const Dataset unlike = recording.open().value();
  EXPECT_EQ(unlike.sample_bits, 16);
  EXPECT_THAT(unlike.notes, ::testing::Contains(HasSubstr("the right ones of 16 bits in 16; one view is too dark")));
}

TEST(FileStereoCamera, SkipsAndCountsFramesWithoutPartner) {
  const test::Recording recording(4);
  std::filesystem::remove(recording.left(0));
  std::filesystem::remove(recording.right(2));
  Playing playing(recording.open().value());
  EXPECT_EQ(playing.camera.next(kTimeout)->frame_index, 1);
  EXPECT_EQ(playing.camera.next(kTimeout)->frame_index, 3);
  EXPECT_EQ(playing.camera.next(kTimeout).error().code, ErrorCode::kEndOfStream);
  EXPECT_EQ(playing.camera.counters().skipped_missing_side, 2U);
  EXPECT_EQ(playing.camera.counters().gaps, 0U);
}

TEST(FileStereoCamera, CountsGapsInTheNumbering) {
  const test::Recording recording(6);
  for (const int lost : {1, 2, 4}) {
    std::filesystem::remove(recording.left(lost));
    std::filesystem::remove(recording.right(lost));
  }
  Playing playing(recording.open().value());
  EXPECT_EQ(playing.camera.next(kTimeout)->frame_index, 0);
  const auto after_gap = playing.camera.next(kTimeout);
  EXPECT_EQ(after_gap->frame_index, 3);
  EXPECT_EQ(after_gap->timestamp_ns, 300'000'000);
  EXPECT_EQ(playing.camera.next(kTimeout)->frame_index, 5);
  EXPECT_EQ(playing.camera.counters().gaps, 3U);
}

TEST(FileStereoCamera, SkipsCountsAndReportsDamagedFrames) {
  const test::Recording recording(5);
  test::write_cut_image(recording.left(1), 60);
  test::write_text(recording.right(2), "");
  test::write_image(recording.right(3), 1, test::kWidth + 1, test::kHeight);
  Playing playing(recording.open().value());
  EXPECT_EQ(playing.camera.next(kTimeout)->frame_index, 0);
  EXPECT_EQ(playing.camera.next(kTimeout)->frame_index, 4);
  EXPECT_EQ(playing.camera.counters().skipped_unreadable, 3U);
  ASSERT_EQ(playing.camera.warnings().size(), 3U);
  EXPECT_THAT(playing.camera.warnings()[0], HasSubstr(recording.left(1) + ": is truncated"));
  EXPECT_THAT(playing.camera.warnings()[1], HasSubstr(recording.right(2) + ": is empty (0 bytes)"));
  EXPECT_THAT(playing.camera.warnings()[2], HasSubstr("49x32 pixels, expected 48x32"));
}

TEST(FileStereoCamera, KeepsOnlyTheFirstWarnings) {
  const test::Recording recording(5);
  for (const int i : {1, 2, 3}) {
    test::write_text(recording.left(i), "");
  }
  Playing playing(recording.open().value(), {.max_warnings = 2});
  while (playing.camera.next(kTimeout)) {
  }
  EXPECT_EQ(playing.camera.counters().skipped_unreadable, 3U);
  ASSERT_EQ(playing.camera.warnings().size(), 2U);
  EXPECT_THAT(playing.camera.warnings()[0], HasSubstr("000001"));
}

TEST(FileStereoCamera, ARecordingWithoutOneReadablePairIsAnError) {
  const test::Recording recording(2);
  Dataset dataset = recording.open().value();
  test::write_cut_image(recording.left(0), 50);
  test::write_cut_image(recording.right(1), 50);
  Playing playing(dataset, {.passes = 3, .max_warnings = 0});
  const auto frame = playing.camera.next(kTimeout);
  ASSERT_FALSE(frame);
  EXPECT_EQ(frame.error().code, ErrorCode::kBadFormat);
  EXPECT_THAT(frame.error().message, HasSubstr("none of its 2 frames could be read"));
  EXPECT_THAT(frame.error().message, HasSubstr(recording.left(0)));
}

TEST(FileStereoCamera, NumbersAndTimesKeepIncreasingOverPasses) {
  const test::Recording recording(5);
  std::filesystem::remove(recording.left(3));
  std::filesystem::remove(recording.right(3));
  std::filesystem::remove(recording.right(4));
  Playing playing(recording.open().value(), {.passes = 3});
  EXPECT_EQ(playing.camera.info().frame_count, 12);
  std::int64_t previous_index = -1;
  std::int64_t previous_time_ns = -1;
  int frames = 0;
  while (const auto frame = playing.camera.next(kTimeout)) {
    EXPECT_GT(frame->frame_index, previous_index);
    EXPECT_GT(frame->timestamp_ns, previous_time_ns);
    EXPECT_EQ(frame->timestamp_ns, frame->frame_index * 100'000'000);
    EXPECT_EQ(frame->name, "00000" + std::to_string(frame->frame_index % 5));
    previous_index = frame->frame_index;
    previous_time_ns = frame->timestamp_ns;
    ++frames;
  }
  EXPECT_EQ(frames, 9);
  EXPECT_EQ(playing.camera.counters().gaps, 3U);
  EXPECT_EQ(playing.camera.counters().skipped_missing_side, 3U);
}

TEST(FileStereoCamera, IsLostWhenTheFolderGoesAndRecovers) {
  const test::Recording recording(4);
  Playing playing(recording.open().value());
  ASSERT_TRUE(playing.camera.next(kTimeout));
  const std::filesystem::path away = recording.path().parent_path() / "away";
  std::filesystem::rename(recording.path(), away);
  const auto lost = playing.camera.next(kTimeout);
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().code, ErrorCode::kDisconnected);
  EXPECT_EQ(playing.camera.state(), CameraState::kLost);
  EXPECT_EQ(playing.camera.next(kTimeout).error().code, ErrorCode::kIllegalState);
  EXPECT_EQ(playing.camera.recover().error().code, ErrorCode::kDisconnected);
  EXPECT_EQ(playing.camera.state(), CameraState::kLost);
  std::filesystem::rename(away, recording.path());
  ASSERT_TRUE(playing.camera.recover());
  EXPECT_EQ(playing.camera.state(), CameraState::kRecovering);
  EXPECT_EQ(playing.camera.next(kTimeout)->frame_index, 1);
  EXPECT_EQ(playing.camera.state(), CameraState::kStreaming);
  EXPECT_EQ(playing.camera.counters().skipped_unreadable, 0U);
}

TEST(FileStereoCamera, OpenNoticesThatTheFolderHasGone) {
  const test::Recording recording(1);
  const Dataset dataset = recording.open().value();
  Arena arena(FileStereoCamera::required_bytes(dataset, {}));
  auto camera = FileStereoCamera::create(dataset, {}, arena);
  ASSERT_TRUE(camera);
  std::filesystem::remove_all(recording.path());
  const Status opened = camera->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(camera->state(), CameraState::kClosed);
}

TEST(FileStereoCamera, TakesExactlyWhatItAnnounces) {
  const test::Recording recording(1);
  const Dataset dataset = recording.open().value();
  const std::size_t bytes = FileStereoCamera::required_bytes(dataset, {});
  Arena exact(bytes);
  ASSERT_TRUE(FileStereoCamera::create(dataset, {}, exact));
  EXPECT_EQ(exact.used_bytes(), bytes);
  Arena small(bytes - Arena::kAlignment);
  const auto refused = FileStereoCamera::create(dataset, {}, small);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kCapacity);
}

TEST(FileStereoCamera, ValidatesItsConfiguration) {
  const test::Recording recording(1);
  Arena arena(std::size_t{1} << 20);
  const auto code_of = [&](FileCameraConfig config) {
    return FileStereoCamera::create(recording.open().value(), config, arena).error().code;
  };
  EXPECT_EQ(code_of({.passes = 0}), ErrorCode::kInvalidConfig);
  EXPECT_EQ(code_of({.max_warnings = -1}), ErrorCode::kInvalidConfig);
  EXPECT_EQ(FileStereoCamera::create(Dataset{}, {}, arena).error().code, ErrorCode::kInvalidArgument);
}

TEST(FileStereoCamera, SkipsWhatIsNoFile) {
  const test::Recording recording(3);
  std::filesystem::remove(recording.left(1));
  ASSERT_EQ(::mkfifo(recording.left(1).c_str(), 0600), 0);
  Playing playing(recording.open().value());
  EXPECT_EQ(playing.camera.next(kTimeout)->frame_index, 0);
  EXPECT_EQ(playing.camera.next(kTimeout)->frame_index, 2);
  EXPECT_EQ(playing.camera.counters().skipped_unreadable, 1U);
  EXPECT_THAT(playing.camera.warnings(), ::testing::ElementsAre(HasSubstr(recording.left(1) + ": is a named pipe")));
}

TEST(FileStereoCamera, NamesTheFilesOfAFrame) {
  const test::Recording recording(2);
  const Playing playing(recording.open().value(), {.passes = 3});
  EXPECT_EQ(playing.camera.image_name(1, true), recording.left(1));
  EXPECT_EQ(playing.camera.image_name(4, false), recording.right(0)) << "in the third pass";
}

TEST(FileStereoCamera, RefusesMorePassesThanFrameNumbersAndTimesAllow) {
  const test::Recording recording(2);
  test::write_text((recording.path() / "times.txt").string(), "4611680000000000000\n4611680000100000000\n");
  const auto dataset = recording.open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  Arena arena(std::size_t{1} << 20);
  EXPECT_TRUE(FileStereoCamera::create(*dataset, {.passes = 10'000}, arena));
  const auto refused = FileStereoCamera::create(*dataset, {.passes = 1'000'000}, arena);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidConfig);
  EXPECT_THAT(refused.error().message, HasSubstr("sequence: can be played"));
}

}  // namespace
}  // namespace kinetrace::hal

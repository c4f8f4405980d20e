// Common behaviour of all layouts, on the simplest: KITTI odometry.
#include "kinetrace/hal/dataset.hpp"

#include <filesystem>
#include <sys/stat.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "recording_for_test.hpp"

namespace kinetrace::hal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

void expect_error(const Result<Dataset>& dataset, ErrorCode code, const std::string& what) {
  ASSERT_FALSE(dataset) << "expected: " << what;
  EXPECT_EQ(dataset.error().code, code) << dataset.error().message;
  EXPECT_THAT(dataset.error().message, HasSubstr(what));
  EXPECT_THAT(dataset.error().message, Not(HasSubstr("\n")));
}

TEST(ParseLayout, KnowsEveryNameItPrints) {
  for (const std::string_view name : layout_names()) {
    const auto layout = parse_layout(name);
    ASSERT_TRUE(layout);
    EXPECT_EQ(to_string(*layout), name);
  }
  const auto unknown = parse_layout("kitti");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(unknown.error().message, HasSubstr("unknown dataset layout 'kitti'; use kitti-raw,"));
  EXPECT_THAT(parse_layout("citiscapes").error().message, HasSubstr("; did you mean cityscapes?"));
}

TEST(OpenDataset, ListsFramesWithNumbersAndTimes) {
  const auto dataset = test::Recording(3).open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  ASSERT_EQ(dataset->frames.size(), 3U);
  EXPECT_EQ(dataset->frames[2].frame_index, 2);
  EXPECT_EQ(dataset->frames[2].timestamp_ns, 200'000'000);
  EXPECT_EQ(dataset->frames[2].name(), "000002");
  EXPECT_NEAR(dataset->nominal_rate_hz, 10.0, 1e-9);
  EXPECT_GT(dataset->max_file_bytes, 0U);
  EXPECT_THAT(dataset->notes, IsEmpty());
  EXPECT_EQ(dataset->name, "sequence");
  EXPECT_EQ(dataset->layout, DatasetLayout::kKittiOdometry);
}

TEST(OpenDataset, AcceptsASingleFrame) {
  const auto dataset = test::Recording(1).open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(dataset->frames.size(), 1U);
  EXPECT_NEAR(dataset->nominal_rate_hz, 10.0, 1e-9);
}

TEST(OpenDataset, NamesAMissingFolder) {
  expect_error(open_dataset({.layout = DatasetLayout::kEuroc, .path = "/no/such/folder"}), ErrorCode::kNotFound,
               "/no/such/folder: no such folder");
}

TEST(OpenDataset, RejectsAnImpossibleRate) {
  const test::Recording recording(1);
  for (const double rate_hz : {-1.0, 1e-5, 1001.0, std::nan("")}) {
    expect_error(
        open_dataset({.layout = DatasetLayout::kKittiOdometry, .path = recording.path(), .frame_rate_hz = rate_hz}),
        ErrorCode::kInvalidArgument, "dataset.frame_rate_hz");
  }
}

TEST(OpenDataset, AssumesTheRateWhereThereAreNoTimes) {
  const test::Recording recording(3);
  std::filesystem::remove(recording.path() / "times.txt");
  const auto dataset = recording.open();
  ASSERT_TRUE(dataset);
  EXPECT_EQ(dataset->frames[1].timestamp_ns, 100'000'000);
  ASSERT_EQ(dataset->notes.size(), 1U);
  EXPECT_THAT(dataset->notes[0], HasSubstr("10 Hz assumed"));
  const auto faster =
      open_dataset({.layout = DatasetLayout::kKittiOdometry, .path = recording.path(), .frame_rate_hz = 25});
  ASSERT_TRUE(faster);
  EXPECT_EQ(faster->frames[1].timestamp_ns, 40'000'000);
}

TEST(OpenDataset, GapsInTheNumberingWidenTheTimeBetweenFrames) {
  const test::Recording recording(6);
  for (const int lost : {2, 3}) {
    std::filesystem::remove(recording.left(lost));
    std::filesystem::remove(recording.right(lost));
  }
  const auto dataset = recording.open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  ASSERT_EQ(dataset->frames.size(), 4U);
  EXPECT_EQ(dataset->frames[2].frame_index, 4);
  EXPECT_EQ(dataset->frames[2].timestamp_ns, 400'000'000);
}

TEST(OpenDataset, KeepsFramesWithOneSideAndSaysSo) {
  const test::Recording recording(4);
  std::filesystem::remove(recording.left(1));
  std::filesystem::remove(recording.right(2));
  const auto dataset = recording.open();
  ASSERT_TRUE(dataset);
  EXPECT_EQ(dataset->frames.size(), 4U);
  EXPECT_EQ(dataset->frames.complete_count(), 2U);
  EXPECT_THAT(dataset->notes, ElementsAre(HasSubstr("2 of 4 frames have only one side")));
}

TEST(OpenDataset, TakesTimesOfAClipByPlace) {
  const test::Recording recording(5);
  std::filesystem::remove(recording.left(0));
  std::filesystem::remove(recording.right(0));
  test::write_text((recording.path() / "times.txt").string(), "10\n11\n12\n13\n");
  const auto dataset = recording.open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(dataset->frames[0].frame_index, 1);
  EXPECT_EQ(dataset->frames[0].timestamp_ns, 10'000'000'000);
  EXPECT_EQ(dataset->frames[3].timestamp_ns, 13'000'000'000);
}

TEST(OpenDataset, RejectsDamagedTimes) {
  const test::Recording recording(3);
  const std::string times = (recording.path() / "times.txt").string();
  test::write_text(times, "0\n1\n");
  expect_error(recording.open(), ErrorCode::kBadFormat, times + ": has 2 times for 3 frames up to number 2");
  test::write_text(times, "0\nxx\n2\n");
  expect_error(recording.open(), ErrorCode::kBadFormat, times + ": entry 2 'xx' is no time");
  test::write_text(times, "0\n2\n1\n");
  expect_error(recording.open(), ErrorCode::kBadFormat, times + ": frame 000002 does not come after");
  test::write_text(times, "0\n1\n1\n");
  expect_error(recording.open(), ErrorCode::kBadFormat, times + ": frame 000002 does not come after");
  test::write_text(times, "");
  expect_error(recording.open(), ErrorCode::kBadFormat, times + ": is empty");
}

TEST(OpenDataset, RejectsTimesInAnotherUnit) {
  const test::Recording recording(3);
  const std::string times = (recording.path() / "times.txt").string();
  const std::string fast = times + ": frames are 1 ns apart (median)";
  test::write_text(times, "1403715273262142976\n1403715273262142977\n1403715273262142978\n");
  expect_error(recording.open(), ErrorCode::kBadFormat, fast.c_str());
  const std::string slow = times + ": frames are 3e+08 s apart (median)";
  test::write_text(times, "0\n3e8\n6e8\n");
  expect_error(recording.open(), ErrorCode::kBadFormat, slow.c_str());
  test::write_text(times, "0\n0.0005\n0.001\n");
  const auto odd = recording.open();
  ASSERT_TRUE(odd);
  EXPECT_THAT(odd->notes, ElementsAre(HasSubstr("frames are 500000 ns apart (median), which is faster than 1000 Hz")));
  test::write_text(times, "0\n100\n200\n");
  const auto milliseconds = recording.open();
  ASSERT_TRUE(milliseconds);
  EXPECT_THAT(milliseconds->notes, ElementsAre(HasSubstr("frames are 100 s apart (median), too far to follow")));
  const test::Recording longer(4);
  test::write_text((longer.path() / "times.txt").string(), "0\n0.1\n0.2\n3e8\n");
  const auto jump = longer.open();
  ASSERT_TRUE(jump) << jump.error().message;
  EXPECT_THAT(jump->notes, ElementsAre(HasSubstr("1 of the steps between frames are shorter than 0.1 ms or longer")));
}

TEST(OpenDataset, NamesWhatIsNoFileOfTimes) {
  const test::Recording recording(3);
  const std::filesystem::path times = recording.path() / "times.txt";
  std::filesystem::remove(times);
  ASSERT_EQ(::mkfifo(times.c_str(), 0600), 0);
  expect_error(recording.open(), ErrorCode::kBadFormat, times.string() + ": is a named pipe");
}

TEST(OpenDataset, RejectsAnEmptySequence) {
  const test::Recording recording(1);
  std::filesystem::remove(recording.right(0));
  expect_error(recording.open(), ErrorCode::kNotFound, (recording.path() / "image_1").string() + ": holds no images");
}

TEST(OpenDataset, RejectsSidesWithoutACommonName) {
  const test::Recording recording(2);
  std::filesystem::remove(recording.left(0));
  std::filesystem::remove(recording.right(1));
  expect_error(recording.open(), ErrorCode::kInvalidArgument, "no image has a partner of the same name");
}

TEST(OpenDataset, RejectsDifferentSizesLeftAndRight) {
  const test::Recording recording(1);
  test::write_image(recording.right(0), 1, test::kWidth, test::kHeight - 1);
  expect_error(recording.open(), ErrorCode::kBadFormat, "is 48x31 pixels, but the left image is 48x32");
}

TEST(OpenDataset, RejectsARecordingOfUnreadableImages) {
  const test::Recording recording(2);
  test::write_text(recording.left(0), "");
  test::write_text(recording.left(1), "");
  expect_error(recording.open(), ErrorCode::kBadFormat, recording.left(0) + ": is empty (0 bytes)");
}

TEST(OpenDataset, LooksPastADamagedFirstFrame) {
  const test::Recording recording(2);
  test::write_text(recording.left(0), "");
  const auto dataset = recording.open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(dataset->calibration.raw_width_px(), test::kWidth);
}

TEST(OpenDataset, RejectsTwoKindsOfImageInOneFolder) {
  const test::Recording recording(1);
  test::write_text((recording.path() / "image_0" / "000001.pgm").string(), "P5 1 1 255\nx");
  expect_error(recording.open(), ErrorCode::kUnsupported, "holds both");
}

}  // namespace
}  // namespace kinetrace::hal

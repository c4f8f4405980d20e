// Recordings in KITTI's layout: read back exactly, up to the first damage.
#include <fstream>
#include <functional>
#include <initializer_list>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fake_disk.hpp"
#include "raw_recording_for_test.hpp"

namespace kinetrace::hal::test {
namespace {

using ::testing::HasSubstr;

TEST_F(Raw, KittisLayoutIsReadBackExactly) {
  record(config(RawFormat::kKittiRaw), kWithGap);
  const Result<Dataset> dataset = open(RawFormat::kKittiRaw);
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_TRUE(dataset->calibration.rectified.has_value());
  EXPECT_EQ(dataset->calibration.rectified->baseline_m, rectified_rig().rectified->baseline_m);
  expect_frames(*dataset, kWithGap);
}

// The images of frame `index` are harder and harder to compress, the right one harder than the left.
TEST_F(Raw, WhatADiskTookBeforeItWasFullIsWholeInKittisLayoutToo) {
  // Limits at which the left image, the right one, or one of the lists of times does not fit.
  for (const rlim_t limit : {100U, 130U, 160U, 200U, 240U, 300U, 400U, 700U}) {
    const auto recorder = make(config(RawFormat::kKittiRaw)).value();
    Status full;
    {
      const FileSizeLimit limited(limit);
      for (std::int64_t index = 0; full && index < 1000; ++index) {
        StereoFrame grown = frame(index);
        for (std::size_t view = 0; view < 2; ++view) {
          std::fill(
              pixels_[view].begin() + std::min<std::ptrdiff_t>((index / 2) * 8 * static_cast<int>(view + 1), 1000),
              pixels_[view].end(), std::uint8_t{0});
        }
        full = recorder->write(grown);
      }
    }
    ASSERT_FALSE(full) << limit;
    EXPECT_EQ(full.error().code, ErrorCode::kIo);
    const std::int64_t whole = recorder->frames();
    const std::filesystem::path drive = raw() / "drive_0001_sync";
    for (const char* view : {"image_00", "image_01"}) {
      EXPECT_EQ(std::distance(std::filesystem::directory_iterator(drive / view / "data"), {}), whole) << limit;
      EXPECT_EQ(std::filesystem::file_size(drive / view / "timestamps.txt"), 30U * static_cast<std::size_t>(whole));
    }
    if (whole > 0) {
      const Result<Dataset> dataset = open(RawFormat::kKittiRaw);
      ASSERT_TRUE(dataset) << limit << dataset.error().message;
      EXPECT_EQ(dataset->frames.complete_count(), static_cast<std::size_t>(whole));
      EXPECT_TRUE(dataset->notes.empty());
    }
    clear();
  }
}

using Path = std::filesystem::path;

void remove_images(const Path& drive, std::initializer_list<const char*> cameras,
                   std::initializer_list<const char*> numbers) {
  for (const char* camera : cameras) {
    for (const char* number : numbers) {
      std::filesystem::remove(drive / camera / "data" / (std::string(number) + ".png"));
    }
  }
}

void shorten(const Path& file, std::uintmax_t bytes) {
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - bytes);
}

/// Damage to the end of a recording of kWithGap by a loss of power, and the remaining frames.
struct Loss {
  const char* what;
  std::function<void(const Path& drive)> happens;
  std::vector<std::int64_t> left;
};

std::vector<Loss> losses_of_images() {
  return {
      {"a right image that never came",
       [](const Path& drive) { remove_images(drive, {"image_01"}, {"0000000010"}); },
       {3, 4, 5, 9}},
      {"both images",
       [](const Path& drive) {
         remove_images(drive, {"image_00", "image_01"}, {"0000000010"});
       },
       {3, 4, 5, 9}},
      {"the content of an image",
       [](const Path& drive) { std::filesystem::resize_file(drive / "image_00/data/0000000010.png", 0); },
       {3, 4, 5, 9}},
      {"half an image", [](const Path& drive) { shorten(drive / "image_01/data/0000000010.png", 40); }, {3, 4, 5, 9}},
      {"an unfinished next image",
       [](const Path& drive) { std::ofstream(drive / "image_00/data/0000000011.part") << "PNG"; }, kWithGap},
      {"a next left image without anything else",
       [](const Path& drive) {
         std::filesystem::copy(drive / "image_00/data/0000000010.png", drive / "image_00/data/0000000011.png");
       },
       kWithGap},
      {"many images and no more gaps than would make up for the lines",
       [](const Path& drive) {
         remove_images(drive, {"image_00", "image_01"}, {"0000000010", "0000000009", "0000000005"});
       },
       {3, 4}},
  };
}

std::vector<Loss> losses_of_lines() {
  return {
      {"a line of time", [](const Path& drive) { shorten(drive / "image_00/timestamps.txt", 30); }, kWithGap},
      {"half a line of time", [](const Path& drive) { shorten(drive / "image_00/timestamps.txt", 13); }, kWithGap},
      {"the end of a line", [](const Path& drive) { shorten(drive / "frames.txt", 1); }, {3, 4, 5, 9}},
      {"half a line", [](const Path& drive) { shorten(drive / "frames.txt", 7); }, {3, 4, 5, 9}},
      {"several lines", [](const Path& drive) { shorten(drive / "frames.txt", 50); }, {3, 4}},
      {"the content behind a length",
       [](const Path& drive) {
         const auto bytes = std::filesystem::file_size(drive / "frames.txt");
         std::filesystem::resize_file(drive / "frames.txt", bytes - 30);
         std::filesystem::resize_file(drive / "frames.txt", bytes);
       },
       {3, 4, 5}},
  };
}

TEST_F(Raw, KittisLayoutIsReadableWhateverALossOfPowerTookOfItsEnd) {
  for (const std::vector<Loss>& losses : {losses_of_images(), losses_of_lines()}) {
    for (const Loss& loss : losses) {
      SCOPED_TRACE(loss.what);
      record(config(RawFormat::kKittiRaw), kWithGap);
      loss.happens(raw() / "drive_0001_sync");
      const Result<Dataset> dataset = open(RawFormat::kKittiRaw);
      ASSERT_TRUE(dataset) << dataset.error().message;
      expect_frames(*dataset, loss.left);
      clear();
    }
  }
}

TEST_F(Raw, WithoutAWholeFrameThereIsNoRecording) {
  record(config(RawFormat::kKittiRaw), {0});
  const std::filesystem::path times = raw() / "drive_0001_sync/frames.txt";
  std::filesystem::resize_file(times, std::filesystem::file_size(times) - 1);
  const Result<Dataset> dataset = open(RawFormat::kKittiRaw);
  ASSERT_FALSE(dataset);
  EXPECT_EQ(dataset.error().code, ErrorCode::kBadFormat);
  EXPECT_THAT(dataset.error().message, HasSubstr("frames.txt"));
}

}  // namespace
}  // namespace kinetrace::hal::test

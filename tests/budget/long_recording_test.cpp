// A file camera that plays for hours takes no more memory than in its first minute.
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "kinetrace/hal/file_stereo_camera.hpp"
#include "kinetrace/hal/frame_guard.hpp"
#include "kinetrace/hal/raw_recorder.hpp"
#include "resident_memory.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

constexpr int kFrames = 100'000;
constexpr int kSteadyFrom = 1000;
constexpr std::uint64_t kMaxGrowthBytes = 1U << 18U;  // 2.6 bytes a frame.
constexpr int kWidth = 64;
constexpr int kHeight = 48;

void play_and_expect_flat(const hal::Dataset& dataset, int passes) {
  Arena arena(hal::FileStereoCamera::required_bytes(dataset, {}));
  auto file = hal::FileStereoCamera::create(dataset, {.passes = passes}, arena);
  ASSERT_TRUE(file) << file.error().message;
  hal::FrameGuard camera(std::make_unique<hal::FileStereoCamera>(std::move(*file)), {.mend_times = false});
  ASSERT_TRUE(camera.open() && camera.start());
  std::uint64_t early_bytes = 0;
  std::int64_t last_index = -1;
  for (int i = 0; i < kFrames; ++i) {
    const Result<StereoFrame> frame = camera.next(std::chrono::milliseconds(1));
    ASSERT_TRUE(frame) << i << ": " << frame.error().message;
    ASSERT_GT(frame->frame_index, last_index);
    last_index = frame->frame_index;
    if (i == kSteadyFrom) {
      early_bytes = resident_bytes();
    }
  }
  if (early_bytes == 0) {
    GTEST_SKIP() << "this system does not tell the memory of a process";
  }
  EXPECT_LE(resident_bytes(), early_bytes + kMaxGrowthBytes);
}

StereoFrame noise(std::vector<std::uint8_t>& pixels, std::int64_t index) {
  pixels.resize(kWidth * kHeight);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] = static_cast<std::uint8_t>(i * 31 + static_cast<std::size_t>(index) * 7);
  }
  const GrayView image{pixels.data(), kWidth, kHeight, kWidth};
  return {index, index * 33'333'333, {}, image, image};
}

hal::RigCalibration rig() {
  hal::RigCalibration rig;
  rig.source = "test";
  rig.rectified = StereoGeometry{40, 40, 32, 24, 0.1, kWidth, kHeight};
  return rig;
}

TEST(LongRecording, AHundredThousandFramesOfAContainerTakeNoMore) {
  constexpr int kRecorded = 500;
  const TempFolder folder;
  const hal::RawRecorderConfig config{
      .directory = folder.path() / "raw", .calibration = rig(), .rate_hz = 30.0, .keep_free_bytes = 0};
  Arena arena(hal::RawRecorder::required_bytes(config));
  const auto recorder = hal::RawRecorder::create(config, arena).value();
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < kRecorded; ++i) {
    ASSERT_TRUE(recorder->write(noise(pixels, i)));
  }
  const hal::Dataset dataset =
      hal::open_dataset({.layout = hal::DatasetLayout::kContainer, .path = config.directory}).value();
  play_and_expect_flat(dataset, kFrames / kRecorded);
}

TEST(LongRecording, AHundredThousandFramesOfImageFilesTakeNoMore) {
  constexpr int kRecorded = 20;
  const TempFolder folder;
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < kRecorded; ++i) {
    for (const char* view : {"image_0", "image_1"}) {
      std::filesystem::create_directories(folder.path() / view);
      std::ofstream file(folder.path() / view / (std::to_string(100 + i) + ".pgm"), std::ios::binary);
      const GrayView image = noise(pixels, i).left;
      file << "P5\n" << kWidth << " " << kHeight << "\n255\n";
      file.write(reinterpret_cast<const char*>(image.data), kWidth * kHeight);
    }
  }
  std::ofstream(folder.path() / "calib.txt") << "P0: 40 0 32 0 0 40 24 0 0 0 1 0\nP1: 40 0 32 -4 0 40 24 0 0 0 1 0\n";
  const hal::Dataset dataset =
      hal::open_dataset({.layout = hal::DatasetLayout::kKittiOdometry, .path = folder.path()}).value();
  play_and_expect_flat(dataset, kFrames / kRecorded);
}

}  // namespace
}  // namespace kinetrace::test

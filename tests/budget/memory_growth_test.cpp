// Camera, rectifier, pipeline and recorder in one process, with its memory measured at two frames.
#include <chrono>

#include <gtest/gtest.h>

#include "budget_recording.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/pipeline/pipeline.hpp"
#include "kinetrace/recording/run_recorder.hpp"
#include "resident_memory.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

constexpr int kSettledIn = 20;  // Frames after which every part has touched its memory.
constexpr std::uint64_t kMaxGrowthBytes = 1U << 19U;

struct Growth {
  std::int64_t frames = 0;
  std::uint64_t early_bytes = 0;
  std::uint64_t late_bytes = 0;
};

/// Plays the recording as the program does and measures after frame kSettledIn and after the last one.
Growth play(const BudgetRecording& recording, const std::filesystem::path& out) {
  const std::size_t colon = recording.dataset.find(':');
  hal::Dataset dataset = hal::open_dataset({.layout = hal::parse_layout(recording.dataset.substr(0, colon)).value(),
                                            .path = recording.dataset.substr(colon + 1)})
                             .value();
  pipeline::PipelineConfig config;
  config.segmentation = segmentation::parse_segmentation(recording.segmentation).value();
  const hal::RigCalibration calibration = dataset.calibration;
  Arena arena(64U << 20U);
  hal::Rectifier rectifier = hal::Rectifier::create(calibration, {}, arena).value();
  auto camera = hal::FileStereoCamera::create(std::move(dataset), {.passes = passes()}, arena).value();
  auto pipeline = pipeline::Pipeline::create(config, rectifier.geometry(), arena).value();
  auto recorder = recording::RunRecorder::create({.directory = out, .geometry = rectifier.geometry()}, arena).value();
  EXPECT_TRUE(camera.open() && camera.start());

  Growth growth;
  for (;;) {
    const Result<StereoFrame> frame = camera.next(std::chrono::seconds(1));
    if (!frame) {
      EXPECT_EQ(frame.error().code, ErrorCode::kEndOfStream) << frame.error().message;
      break;
    }
    const FrameResult* result = pipeline.process(rectifier.process(*frame).value()).value();
    EXPECT_TRUE(recorder.record(*result).has_value());
    if (++growth.frames == kSettledIn) {
      growth.early_bytes = resident_bytes();
    }
  }
  growth.late_bytes = resident_bytes();
  return growth;
}

void expect_flat(const BudgetRecording& recording) {
  const TempFolder out;
  const Growth growth = play(recording, out.path() / "run");
  EXPECT_EQ(growth.frames, passes() * recording.frames);
  if (growth.early_bytes == 0) {
    GTEST_SKIP() << "this system does not tell the memory of a process";
  }
  EXPECT_LE(growth.late_bytes, growth.early_bytes + kMaxGrowthBytes)
      << "from " << growth.early_bytes << " to " << growth.late_bytes << " bytes in " << growth.frames - kSettledIn
      << " frames";
}

TEST(MemoryGrowth, ARenderedStreetPlayedAgainAndAgainTakesNoMore) {
  const TempFolder folder;
  expect_flat(rendered_clip(folder.path()));
}

TEST(MemoryGrowth, ARealStreetPlayedAgainAndAgainTakesNoMore) {
  const auto recording = street_clip();
  if (!recording) {
    GTEST_SKIP() << "no recordings: set KINETRACE_DATA";
  }
  expect_flat(*recording);
}

}  // namespace
}  // namespace kinetrace::test

// Camera, rectifier, pipeline and recorder in one process, with its memory measured at two frames.
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "budget_recording.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/pipeline/pipeline.hpp"
#include "kinetrace/recording/run_recorder.hpp"
#include "resident_memory.hpp"
#include "street_drive.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

constexpr int kSteadyFrom = 20;  // Frames after which every part has touched its memory.
constexpr std::uint64_t kMaxGrowthBytes = 1U << 19U;

struct Growth {
  std::int64_t frames = 0;
  std::uint64_t early_bytes = 0;
  std::uint64_t late_bytes = 0;
};

/// Plays the recording as the program does and measures after frame kSteadyFrom and after the last one.
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
    if (++growth.frames == kSteadyFrom) {
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
      << "from " << growth.early_bytes << " to " << growth.late_bytes << " bytes in " << growth.frames - kSteadyFrom
      << " frames";
}

/// Two vehicles cross the view in opposite directions, so that both tracks are born and end in every pass.
StreetDrive crossing_traffic() {
  StereoGeometry rig = small_rig();
  rig.width_px = 240;
  rig.cx_px = 120.0;
  rig.fx_px = 180.0;
  rig.fy_px = 180.0;
  return StreetDrive({{.size_m = {1.5, 1.5, 1.0}, .start_m = {-8.0, 0.6, 9.0}, .velocity_mps = {6.0, 0.0, 5.0}},
                      {.size_m = {1.5, 1.5, 1.0}, .start_m = {9.0, 0.6, 11.0}, .velocity_mps = {-6.0, 0.0, 5.0}}},
                     rig);
}

// A pass is short, so tracks start and end, points are created and retired, and the camera is lost all the time.
TEST(MemoryGrowth, FramesWithoutEndInWhichTracksAreBornAndEndTakeNoMore) {
  constexpr int kPass = 30;
  const int frames = is_long() ? 100'000 : 3'000;
  const StreetDrive street = crossing_traffic();
  MaskFolder masks;
  std::vector<RenderedPair> pairs;
  std::vector<std::string> names;
  for (int i = 0; i < kPass; ++i) {
    names.push_back(stem_of(i));
    pairs.push_back(street.render(i));
    masks.write(pairs.back(), i);
  }
  const TempFolder out;
  pipeline::PipelineConfig config = small_config(masks);
  config.features.max_disparity_px = 48;
  Arena arena(std::size_t{16} << 20U);
  auto pipeline = pipeline::Pipeline::create(config, street.geometry(), arena).value();
  auto recorder = recording::RunRecorder::create(
                      {.directory = out.path() / "run", .geometry = street.geometry(), .colmap = false}, arena)
                      .value();
  std::vector<std::uint64_t> resident;
  FrameCounters counters;
  for (int i = 0; i < frames; ++i) {
    const auto k = static_cast<std::size_t>(i % kPass);
    const FrameResult* result = pipeline.process(pairs[k].at(i, names[k])).value();
    ASSERT_TRUE(recorder.record(*result));
    counters = result->counters;
    if (i % (frames / 10) == frames / 10 - 1) {
      resident.push_back(resident_bytes());
    }
  }
  // At least two tracks in each pass but the first few.
  EXPECT_GT(counters.tracks_ended, static_cast<std::uint64_t>(frames / kPass));
  EXPECT_GT(counters.points_created, static_cast<std::uint64_t>(frames));
  if (resident.front() == 0) {
    GTEST_SKIP() << "this system does not tell the memory of a process";
  }
  std::printf("%d frames, %llu tracks born: resident memory by tenths of the run, KiB:", frames,
              static_cast<unsigned long long>(counters.tracks_born));
  for (const std::uint64_t bytes : resident) {
    std::printf(" %llu", static_cast<unsigned long long>(bytes / 1024));
  }
  std::printf("\n");
  constexpr std::uint64_t kMaxGrowth_bytes = 1U << 18U;
  EXPECT_LE(resident.back(), resident[1] + kMaxGrowth_bytes);
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

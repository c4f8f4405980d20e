#include "simulated_sequence.hpp"

#include <chrono>
#include <optional>
#include <stdexcept>

#include <gtest/gtest.h>

#include "kinetrace/core/allocation_counter.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/pipeline/pipeline.hpp"
#include "output/recording_writer.hpp"
#include "scenes/scenes.hpp"

namespace kinetrace::test {
namespace {

constexpr std::uint64_t kSteadyFrom = 5;  // Frames after which every part has allocated its memory.

void expect_done(const Status& status) {
  if (!status) {
    throw std::runtime_error(status.error().message);
  }
}

}  // namespace

SimulatedSequence::SimulatedSequence(const std::filesystem::path& folder, const std::string& scene, int frames,
                                     int width_px, const simulator::RigErrors& errors, std::uint32_t seed)
    : folder_(folder) {
  simulator::Scene made = simulator::make_scene(scene, seed).value();
  made.rig = simulator::resized(made.rig, width_px, std::nullopt);
  simulator::SimulatorSettings settings;
  settings.errors = errors;
  auto simulator = simulator::StereoSimulator::create(std::move(made), settings).value();
  auto writer = simulator::RecordingWriter::create({folder, true, {}}, simulator).value();
  for (int i = 0; i < frames; ++i) {
    const simulator::SimulatedFrame frame = simulator.frame(i);
    T_world_cam_.push_back(frame.T_world_cam);
    expect_done(writer.write(frame));
  }
  expect_done(writer.finish());
  drive_ = writer.drive();
}

pipeline::PipelineConfig SimulatedSequence::masked() const {
  pipeline::PipelineConfig config;
  config.segmentation.mode = segmentation::SegmentationMode::kMasks;
  config.segmentation.left_dir = (folder_ / "truth/masks/detections_left").string();
  config.segmentation.right_dir = (folder_ / "truth/masks/detections_right").string();
  return config;
}

pipeline::PipelineConfig SimulatedSequence::by_motion() {
  pipeline::PipelineConfig config;
  config.segmentation.mode = segmentation::SegmentationMode::kMotion;
  return config;
}

Followed SimulatedSequence::follow(const pipeline::PipelineConfig& config) const {
  const hal::Dataset dataset = hal::open_dataset({.layout = hal::DatasetLayout::kKittiRaw, .path = drive_}).value();
  Arena arena(std::size_t{64} << 20U);
  auto rectifier = hal::Rectifier::create(dataset.calibration, {}, arena).value();
  auto camera = hal::FileStereoCamera::create(dataset, {}, arena).value();
  auto pipeline = pipeline::Pipeline::create(config, rectifier.geometry(), arena).value();
  expect_done(camera.open());
  expect_done(camera.start());

  Followed followed;
  const auto keep = [&](const FrameResult& result) {
    followed.counters = result.counters;
    followed.rig = result.rig;
    if (result.has_finalised) {
      const auto index = static_cast<std::size_t>(result.finalised.frame_index);
      followed.finalised.push_back({T_world_cam_.at(index),
                                    result.finalised.camera,
                                    {result.finalised.objects.begin(), result.finalised.objects.end()}});
    }
  };
  for (;;) {
    const Result<StereoFrame> frame = camera.next(std::chrono::seconds(1));
    if (!frame) {
      EXPECT_EQ(frame.error().code, ErrorCode::kEndOfStream) << frame.error().message;
      break;
    }
    const RectifiedPair pair = rectifier.process(*frame).value();
    const std::uint64_t before = allocation_counts().own;
    const FrameResult* result = pipeline.process(pair).value();
    if (result->counters.frames > kSteadyFrom) {
      EXPECT_EQ(allocation_counts().own, before) << "frame " << frame->frame_index;
    }
    keep(*result);
  }
  while (const FrameResult* result = pipeline.drain()) {
    keep(*result);
  }
  EXPECT_EQ(followed.finalised.size(), T_world_cam_.size());
  return followed;
}

}  // namespace kinetrace::test

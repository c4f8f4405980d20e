// The paths of camera and objects are bit-identical for any number of threads.
#include <vector>

#include <gtest/gtest.h>

#include "pipeline_run.hpp"
#include "thread_per_round_workers.hpp"

namespace kinetrace::pipeline {
namespace {

using test::KeptEstimate;
using test::MaskFolder;
using test::Mover;
using test::PipelineRun;
using test::small_config;
using test::small_rig;
using test::StreetDrive;
using test::ThreadPerRoundWorkers;

constexpr int kFrames = 12;

std::vector<KeptEstimate> paths(const StreetDrive& street, const MaskFolder& masks, Workers* workers) {
  PipelineRun run(small_config(masks), small_rig(), workers);
  run.drive(street, 0, kFrames);
  run.drain();
  return run.finalised;
}

void expect_same(const Se3& a, const Se3& b) {
  EXPECT_EQ(a.rotation, b.rotation);
  EXPECT_EQ(a.translation, b.translation);
}

TEST(SharedPipeline, TakesTheSamePathsHoweverManyWork) {
  const StreetDrive street({Mover{.velocity_mps = {1.0, 0.0, 8.0}}});
  MaskFolder masks;
  for (int frame = 0; frame < kFrames; ++frame) {
    masks.write(street.render(frame), frame);
  }
  const std::vector<KeptEstimate> alone = paths(street, masks, nullptr);
  ASSERT_EQ(alone.size(), static_cast<std::size_t>(kFrames));
  ASSERT_EQ(alone.back().objects.size(), 1U);
  for (const std::size_t count : {1U, 2U, 3U}) {
    ThreadPerRoundWorkers workers(count);
    const std::vector<KeptEstimate> shared = paths(street, masks, &workers);
    EXPECT_GT(workers.rounds, kFrames);
    ASSERT_EQ(shared.size(), alone.size()) << count;
    for (std::size_t frame = 0; frame < alone.size(); ++frame) {
      SCOPED_TRACE(::testing::Message() << count << " at work, frame " << frame);
      expect_same(shared[frame].camera.T_world_cam, alone[frame].camera.T_world_cam);
      ASSERT_EQ(shared[frame].objects.size(), alone[frame].objects.size());
      for (std::size_t i = 0; i < alone[frame].objects.size(); ++i) {
        expect_same(shared[frame].objects[i].T_world_obj, alone[frame].objects[i].T_world_obj);
        EXPECT_EQ(shared[frame].objects[i].covariance, alone[frame].objects[i].covariance);
      }
    }
  }
}

TEST(SharedPipeline, CanBeMadeForObjectsOfASingleFrame) {
  PipelineConfig config = small_config(segmentation::SegmentationMode::kMotion);
  config.object.window_frames = 1;
  ThreadPerRoundWorkers workers(2);
  PipelineRun run(config, small_rig(), &workers);
  run.drive(StreetDrive(), 0, 3);
  EXPECT_EQ(run.newest.size(), 3U);
}

}  // namespace
}  // namespace kinetrace::pipeline

// The pipeline takes the memory of its plan; less is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline_run.hpp"

namespace kinetrace::pipeline {
namespace {

using segmentation::SegmentationMode;
using test::MaskFolder;
using test::small_config;
using test::small_rig;
using test::StreetDrive;

std::vector<PipelineConfig> configurations(const MaskFolder& masks) {
  PipelineConfig odd = small_config(SegmentationMode::kMotion);
  odd.features.max_features = 501;
  odd.tracking.max_objects = 3;
  odd.object.max_points = 77;
  odd.background.window_frames = 5;
  odd.object.window_frames = 5;
  PipelineConfig large;
  large.segmentation.mode = SegmentationMode::kMotion;
  return {small_config(SegmentationMode::kNone), small_config(SegmentationMode::kMotion), small_config(masks), odd,
          large};
}

class PipelineMemory : public ::testing::Test {
 protected:
  void SetUp() override { masks_.write(StreetDrive().render(0), 0); }
  MaskFolder masks_;
};

TEST_F(PipelineMemory, IsExactlyWhatThePlanSays) {
  for (const PipelineConfig& config : configurations(masks_)) {
    for (const int width : {480, 471}) {
      StereoGeometry geometry = small_rig();
      geometry.width_px = width;
      const Result<MemoryPlan> plan = Pipeline::plan(config, geometry);
      ASSERT_TRUE(plan) << plan.error().message;
      Arena arena(plan->total_bytes());
      const Result<Pipeline> pipeline = Pipeline::create(config, geometry, arena);
      ASSERT_TRUE(pipeline) << pipeline.error().message;
      EXPECT_EQ(arena.used_bytes(), plan->total_bytes());
      for (const MemoryPlanEntry& entry : plan->entries) {
        EXPECT_FALSE(entry.name.empty());
        EXPECT_FALSE(entry.depends_on.empty()) << entry.name;
        EXPECT_TRUE(entry.bytes > 0 || entry.name == "segmentation") << entry.name;
      }
    }
  }
}

TEST_F(PipelineMemory, AutoWithoutANetworkTakesWhatMotionTakes) {
  const Result<MemoryPlan> together = Pipeline::plan(small_config(SegmentationMode::kAuto), small_rig());
  const Result<MemoryPlan> alone = Pipeline::plan(small_config(SegmentationMode::kMotion), small_rig());
  ASSERT_TRUE(together && alone);
  Arena arena(together->total_bytes());
  const Result<Pipeline> pipeline = Pipeline::create(small_config(SegmentationMode::kAuto), small_rig(), arena);
  ASSERT_TRUE(pipeline) << pipeline.error().message;
  EXPECT_EQ(arena.used_bytes(), alone->total_bytes());
  EXPECT_GT(together->total_bytes(), alone->total_bytes());
}

TEST_F(PipelineMemory, AnArenaTooSmallIsRefusedWhateverIsMissing) {
  const PipelineConfig config = small_config(masks_);
  const Result<MemoryPlan> plan = Pipeline::plan(config, small_rig());
  ASSERT_TRUE(plan);
  // One line short of every part's end, and of the whole.
  std::size_t end = 0;
  for (const MemoryPlanEntry& entry : plan->entries) {
    end += entry.bytes;
    Arena arena(end - 1);
    const Result<Pipeline> pipeline = Pipeline::create(config, small_rig(), arena);
    ASSERT_FALSE(pipeline) << entry.name;
    EXPECT_EQ(pipeline.error().code, ErrorCode::kCapacity) << pipeline.error().message;
  }
}

TEST_F(PipelineMemory, PlanAndCreateRefuseABadConfigurationByName) {
  PipelineConfig config = small_config();
  config.background.min_inliers = 0;
  const Result<MemoryPlan> plan = Pipeline::plan(config, small_rig());
  ASSERT_FALSE(plan);
  EXPECT_THAT(plan.error().message, ::testing::HasSubstr("background.min_inliers"));
  Arena arena(1U << 24U);
  const Result<Pipeline> pipeline = Pipeline::create(config, small_rig(), arena);
  ASSERT_FALSE(pipeline);
  EXPECT_EQ(pipeline.error().code, ErrorCode::kInvalidConfig);
  EXPECT_THAT(pipeline.error().message, ::testing::HasSubstr("background.min_inliers"));
  EXPECT_EQ(arena.used_bytes(), 0U);
}

TEST_F(PipelineMemory, AMissingMaskFolderIsNamed) {
  PipelineConfig config = small_config(SegmentationMode::kMasks);
  config.segmentation.left_dir = "/nowhere/masks";
  Arena arena(Pipeline::plan(config, small_rig()).value().total_bytes());
  const Result<Pipeline> pipeline = Pipeline::create(config, small_rig(), arena);
  ASSERT_FALSE(pipeline);
  EXPECT_EQ(pipeline.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(pipeline.error().message, ::testing::HasSubstr("/nowhere/masks"));
}

}  // namespace
}  // namespace kinetrace::pipeline

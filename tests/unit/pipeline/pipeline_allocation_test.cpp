// After the first frames our code does not allocate.
#include <gtest/gtest.h>

#include "kinetrace/core/allocation_counter.hpp"
#include "pipeline_run.hpp"

namespace kinetrace::pipeline {
namespace {

using segmentation::SegmentationMode;
using test::MaskFolder;
using test::Mover;
using test::RenderedPair;
using test::small_config;
using test::small_rig;
using test::StreetDrive;

constexpr int kFrames = 14;

/// Own allocations from the fourth frame on, draining included.
std::uint64_t allocations_of(const PipelineConfig& config, const std::vector<RenderedPair>& pairs) {
  std::vector<std::string> stems;
  stems.reserve(kFrames);
  for (int frame = 0; frame < kFrames; ++frame) {
    stems.push_back(test::stem_of(frame));
  }
  Arena arena(Pipeline::plan(config, small_rig()).value().total_bytes());
  Result<Pipeline> pipeline = Pipeline::create(config, small_rig(), arena);
  EXPECT_TRUE(pipeline);
  std::uint64_t before = 0;
  std::size_t objects = 0;
  for (std::size_t frame = 0; frame < pairs.size(); ++frame) {
    if (frame == 3) {
      before = allocation_counts().own;
    }
    const auto result = pipeline->process(pairs[frame].at(static_cast<std::int64_t>(frame), stems[frame]));
    EXPECT_TRUE(result.has_value());
    objects += (*result)->newest.objects.size();
  }
  while (const FrameResult* result = pipeline->drain()) {
    objects += result->finalised.objects.size();
  }
  const std::uint64_t allocations = allocation_counts().own - before;
  EXPECT_EQ(objects > 0, config.segmentation.mode != SegmentationMode::kNone);
  return allocations;
}

TEST(PipelineAllocations, AreZeroAfterTheThirdFrame) {
  ASSERT_TRUE(allocation_counting_available());
  const StreetDrive street({Mover{.velocity_mps = {1.0, 0.0, 8.0}}});
  MaskFolder masks;
  std::vector<RenderedPair> pairs;
  for (int frame = 0; frame < kFrames; ++frame) {
    // One frame in which all tracks are lost and restarted.
    pairs.push_back(frame == 10 ? test::blank_pair(small_rig(), 0) : street.render(frame));
    if (frame != 6) {
      masks.write(pairs.back(), frame);
    }
  }
  EXPECT_EQ(allocations_of(small_config(SegmentationMode::kNone), pairs), 0U);
  EXPECT_EQ(allocations_of(small_config(SegmentationMode::kMotion), pairs), 0U);
  EXPECT_EQ(allocations_of(small_config(masks), pairs), 0U);
}

}  // namespace
}  // namespace kinetrace::pipeline

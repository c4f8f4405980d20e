// Segmentation never allocates after construction.
#include <array>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <vector>

#include <gtest/gtest.h>

#include "kinetrace/core/allocation_counter.hpp"
#include "kinetrace/imaging/png_writer.hpp"
#include "kinetrace/segmentation/segmenter.hpp"
#include "synthetic_world.hpp"
#include "temp_folder.hpp"

namespace kinetrace::segmentation {
namespace {

/// Always detects the same car.
class SteadyNetwork final : public DelayedMaskSource {
 public:
  void offer(const RectifiedPair& /*pair*/, const PixelBox& /*region_px*/) noexcept override {}
  [[nodiscard]] DelayedMasks take() noexcept override { return {true, &masks_}; }

 private:
  std::array<std::uint16_t, 2> runs_{0, 100};
  std::array<RunLengthMask, 1> car_{RunLengthMask{kVehicleClass, 0.9F, {10, 10, 20, 20}, runs_}};
  MaskSet masks_{car_, {}};
};

void expect_no_allocations_while_something_moves(SegmentationMode mode) {
  ASSERT_TRUE(allocation_counting_available());
  SteadyNetwork network;
  test::WorldConfig world_config;
  test::SyntheticWorld world(world_config, {{{4.0, 1.5, 1.8}, 60}});
  SegmentationConfig config;
  config.mode = mode;
  Arena arena(required_bytes(config, world_config.geometry, world_config.capacity));
  const auto segmenter = make_segmenter(config, world_config.geometry, world_config.capacity, arena,
                                        {.external = nullptr, .network = &network})
                             .value();
  std::uint64_t own = 0;
  std::size_t detections = 0;
  for (int i = 0; i < 10; ++i) {
    SegmentationInput input;
    const FeatureFrame frame =
        world.observe(test::driven(0.5 * i), std::array{test::turned(0.0, {-2.0 + 0.6 * i, 0.6, 20.0})});
    input.features = frame.features;
    input.pair.frame_index = i;
    input.pair.timestamp_ns = frame.timestamp_ns;
    input.ego_valid = i > 0;
    input.T_prev_cam = test::driven(0.5);
    const std::uint64_t before = allocation_counts().own;
    segmenter->load(input.pair, {});
    detections += segmenter->process(input)->left.size();
    own += allocation_counts().own - before;
  }
  EXPECT_GT(detections, 0U);
  EXPECT_EQ(own, 0U);
}

TEST(SegmentationAllocations, AreNoneForMotion) {
  expect_no_allocations_while_something_moves(SegmentationMode::kMotion);
}

TEST(SegmentationAllocations, AreNoneForMotionAndANetworkTogether) {
  expect_no_allocations_while_something_moves(SegmentationMode::kAuto);
}

class MaskFileAllocations : public ::testing::Test {
 protected:
  void write(const char* name, std::uint16_t value, int scale = 1) {
    const std::vector<std::uint16_t> pixels(
        static_cast<std::size_t>(geometry_.width_px * scale) * static_cast<std::size_t>(geometry_.height_px), value);
    ASSERT_TRUE(imaging::write_png_gray16(
        folder_.file(name).c_str(),
        {pixels.data(), geometry_.width_px * scale, geometry_.height_px, geometry_.width_px * scale}));
  }
  void expect_none(std::initializer_list<const char*> stems) {
    ASSERT_TRUE(allocation_counting_available());
    SegmentationConfig config;
    config.mode = SegmentationMode::kMasks;
    config.left_dir = folder_.path().string();
    Arena arena(required_bytes(config, geometry_, 100));
    const auto segmenter = make_segmenter(config, geometry_, 100, arena).value();
    for (const char* stem : stems) {
      SegmentationInput input;
      input.pair.name = stem;
      const std::uint64_t before = allocation_counts().own;
      segmenter->load(input.pair, {});
      EXPECT_TRUE(segmenter->process(input).has_value());
      EXPECT_EQ(allocation_counts().own - before, 0U) << stem;
    }
  }
  test::TempFolder folder_;
  StereoGeometry geometry_ = test::street_rig();
};

TEST_F(MaskFileAllocations, AreNoneForThosePresentAndMissing) {
  write("0.png", 1001);
  expect_none({"0", "1", "0"});
}

TEST_F(MaskFileAllocations, AreNoneForThoseThatCannotBeUsed) {
  write("0.png", 1001);
  write("cut.png", 1001);
  std::filesystem::resize_file(folder_.file("cut.png"), 200);
  write("large.png", 1001, 2);
  std::ofstream(folder_.file("empty.png"));
  std::ofstream(folder_.file("text.png")) << "not a picture at all";
  std::filesystem::create_directory(folder_.file("folder.png"));
  const std::vector<imaging::Rgb8> colours(static_cast<std::size_t>(geometry_.width_px) *
                                           static_cast<std::size_t>(geometry_.height_px));
  ASSERT_TRUE(imaging::write_png_rgb8(folder_.file("colour.png").c_str(),
                                      {colours.data(), geometry_.width_px, geometry_.height_px, geometry_.width_px}));
  expect_none({"0", "cut", "large", "empty", "text", "folder", "colour", "0"});
}

}  // namespace
}  // namespace kinetrace::segmentation

#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/imaging/png_writer.hpp"
#include "kinetrace/segmentation/segmenter.hpp"
#include "temp_folder.hpp"

namespace kinetrace::segmentation {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 96;
constexpr int kHeight = 64;
constexpr StereoGeometry kGeometry{.fx_px = 100.0,
                                   .fy_px = 100.0,
                                   .cx_px = 48.0,
                                   .cy_px = 32.0,
                                   .baseline_m = 0.5,
                                   .width_px = kWidth,
                                   .height_px = kHeight};

class MaskFileSegmenterTest : public ::testing::Test {
 protected:
  void write16(const std::string& name, std::uint16_t value, int width = kWidth, int height = kHeight) {
    std::vector<std::uint16_t> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (int y = 10; y < 30; ++y) {
      std::fill_n(&pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + 20], 20, value);
    }
    ASSERT_TRUE(
        imaging::write_png_gray16(folder_.file(name).c_str(), {pixels.data(), width, height, width}).has_value());
  }
  void write_bytes(const std::string& name, std::string_view bytes) {
    std::ofstream(folder_.file(name), std::ios::binary) << bytes;
  }

  Result<std::unique_ptr<Segmenter>> make(bool with_right = false) {
    SegmentationConfig config;
    config.mode = SegmentationMode::kMasks;
    config.left_dir = (folder_.path() / "left").string();
    config.right_dir = with_right ? (folder_.path() / "right").string() : "";
    arena_ = std::make_unique<Arena>(required_bytes(config, kGeometry, 100));
    return make_segmenter(config, kGeometry, 100, *arena_);
  }
  static DetectionFrame run(Segmenter& segmenter, std::string_view stem, std::int64_t index = 0) {
    SegmentationInput input;
    input.pair.frame_index = index;
    input.pair.name = stem;
    input.pair.geometry = kGeometry;
    segmenter.load(input.pair, {});
    return segmenter.process(input).value();
  }

  test::TempFolder folder_;
  std::unique_ptr<Arena> arena_;
};

TEST_F(MaskFileSegmenterTest, ReadsTheMasksOfAFrameByItsName) {
  write16("left/000007.png", 1003);
  write16("right/000007.png", 2001);
  const auto segmenter = make(true).value();
  const DetectionFrame frame = run(*segmenter, "000007");
  EXPECT_TRUE(frame.available);
  ASSERT_EQ(frame.left.size(), 1U);
  EXPECT_EQ(frame.left[0].class_id, kVehicleClass);
  EXPECT_EQ(frame.left[0].area_px, 400);
  EXPECT_EQ(frame.left_labels.at(20, 10), frame.left[0].label);
  ASSERT_EQ(frame.right.size(), 1U);
  EXPECT_EQ(frame.right[0].class_id, kPedestrianClass);
  EXPECT_EQ(segmenter->counters().detections, 1U);
  EXPECT_EQ(segmenter->warning_count(), 0U);
}

TEST_F(MaskFileSegmenterTest, ReadsEightBitMasks) {
  std::vector<std::uint8_t> pixels(std::size_t{kWidth} * kHeight);
  std::fill_n(pixels.begin(), 100, std::uint8_t{3});
  ASSERT_TRUE(imaging::write_png_gray8(folder_.file("left/a.png").c_str(), {pixels.data(), kWidth, kHeight, kWidth})
                  .has_value());
  const auto segmenter = make().value();
  const DetectionFrame frame = run(*segmenter, "a");
  ASSERT_EQ(frame.left.size(), 1U);
  EXPECT_EQ(frame.left[0].class_id, kUnknownClass);
}

TEST_F(MaskFileSegmenterTest, CountsAMissingFile) {
  write16("left/0.png", 1001);
  const auto segmenter = make().value();
  EXPECT_FALSE(run(*segmenter, "1").available);
  EXPECT_TRUE(run(*segmenter, "0").available);
  EXPECT_EQ(segmenter->counters().frames, 2U);
  EXPECT_EQ(segmenter->counters().frames_missing, 1U);
  ASSERT_EQ(segmenter->warning_count(), 1U);
  EXPECT_THAT(std::string(segmenter->warning(0)), HasSubstr("left/1.png"));
}

TEST_F(MaskFileSegmenterTest, LeavesAMissingRightMaskToTheTracker) {
  write16("left/0.png", 1001);
  write16("right/1.png", 1001);
  const auto segmenter = make(true).value();
  const DetectionFrame frame = run(*segmenter, "0");
  EXPECT_TRUE(frame.available);
  EXPECT_TRUE(frame.right_labels.empty());
  EXPECT_EQ(segmenter->counters().frames_missing, 0U);
}

TEST_F(MaskFileSegmenterTest, CountsFilesItCannotUse) {
  write16("left/0.png", 1001);
  write16("left/small.png", 1001, kWidth / 2, kHeight);
  write16("left/large.png", 1001, kWidth * 4, kHeight * 4);
  write_bytes("left/empty.png", "");
  write_bytes("left/text.png", "not a picture at all");
  std::filesystem::copy(folder_.path() / "left/0.png", folder_.path() / "left/cut.png");
  std::filesystem::resize_file(folder_.path() / "left/cut.png", 60);
  const auto segmenter = make().value();
  std::uint64_t bad = 0;
  for (const char* stem : {"small", "large", "empty", "text", "cut"}) {
    EXPECT_FALSE(run(*segmenter, stem).available) << stem;
    EXPECT_EQ(segmenter->counters().frames_unreadable, ++bad);
    ASSERT_EQ(segmenter->warning_count(), bad);
    EXPECT_THAT(std::string(segmenter->warning(bad - 1)), HasSubstr(std::string(stem) + ".png"));
  }
  EXPECT_TRUE(run(*segmenter, "0").available);
}

TEST_F(MaskFileSegmenterTest, KeepsOnlyTheFirstWarnings) {
  write16("left/0.png", 1001);
  const auto segmenter = make().value();
  for (int i = 1; i < 30; ++i) {
    run(*segmenter, std::to_string(i));
  }
  EXPECT_EQ(segmenter->warning_count(), 8U);
  EXPECT_EQ(segmenter->counters().frames_missing, 29U);
}

TEST_F(MaskFileSegmenterTest, TakesNoNameAndAnEndlessNameForMissing) {
  write16("left/0.png", 1001);
  const auto segmenter = make().value();
  EXPECT_FALSE(run(*segmenter, "").available);
  EXPECT_FALSE(run(*segmenter, std::string(10000, 'x')).available);
  EXPECT_EQ(segmenter->counters().frames_missing, 2U);
}

TEST_F(MaskFileSegmenterTest, WantsEachFrameLoaded) {
  write16("left/0.png", 1001);
  const auto segmenter = make().value();
  run(*segmenter, "0", 5);
  SegmentationInput next;
  next.pair.frame_index = 6;
  EXPECT_EQ(segmenter->process(next).error().code, ErrorCode::kIllegalState);
  segmenter->reset();
  next.pair.frame_index = 5;
  EXPECT_EQ(segmenter->process(next).error().code, ErrorCode::kIllegalState);
}

TEST_F(MaskFileSegmenterTest, NamesAMissingOrEmptyFolder) {
  const auto missing = make();
  ASSERT_FALSE(missing.has_value());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(missing.error().message, HasSubstr((folder_.path() / "left").string()));
  std::filesystem::create_directories(folder_.path() / "left");
  EXPECT_EQ(make().error().code, ErrorCode::kNotFound);
  write16("left/0.png", 1001);
  EXPECT_TRUE(make().has_value());
  EXPECT_THAT(make(true).error().message, HasSubstr("right"));
}

TEST_F(MaskFileSegmenterTest, RefusesTheLeftMasksAsThoseOfTheRightImages) {
  write16("left/0.png", 1001);
  SegmentationConfig config;
  config.mode = SegmentationMode::kMasks;
  config.left_dir = (folder_.path() / "left").string();
  config.right_dir = (folder_.path() / "left" / "." / "").string();
  Arena arena(required_bytes(config, kGeometry, 100));
  const auto segmenter = make_segmenter(config, kGeometry, 100, arena);
  EXPECT_EQ(segmenter.error().code, ErrorCode::kInvalidConfig);
  EXPECT_THAT(segmenter.error().message, HasSubstr("masks of the left images"));
}

TEST_F(MaskFileSegmenterTest, NeedsExactlyTheBytesItAnnounces) {
  write16("left/0.png", 1001);
  SegmentationConfig config;
  config.mode = SegmentationMode::kMasks;
  config.left_dir = (folder_.path() / "left").string();
  const std::size_t bytes = required_bytes(config, kGeometry, 100);
  Arena enough(bytes);
  EXPECT_TRUE(make_segmenter(config, kGeometry, 100, enough).has_value());
  EXPECT_EQ(enough.used_bytes(), bytes);
  Arena too_small(bytes - 1);
  EXPECT_EQ(make_segmenter(config, kGeometry, 100, too_small).error().code, ErrorCode::kCapacity);
}

TEST(NoSegmenter, SaysThatNothingIsThere) {
  SegmentationConfig none;
  none.mode = SegmentationMode::kNone;
  Arena arena(1);
  const auto segmenter = make_segmenter(none, kGeometry, 100, arena).value();
  const DetectionFrame frame = segmenter->process({}).value();
  EXPECT_TRUE(frame.available);
  EXPECT_TRUE(frame.left.empty());
  EXPECT_EQ(required_bytes(none, kGeometry, 100), 0U);
}

}  // namespace
}  // namespace kinetrace::segmentation

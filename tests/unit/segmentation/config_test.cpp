#include "kinetrace/segmentation/config.hpp"

#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::segmentation {
namespace {

using ::testing::HasSubstr;

TEST(ParseSegmentation, UnderstandsEveryForm) {
  EXPECT_EQ(parse_segmentation("none")->mode, SegmentationMode::kNone);
  EXPECT_EQ(parse_segmentation("motion")->mode, SegmentationMode::kMotion);
  EXPECT_EQ(parse_segmentation("dds")->mode, SegmentationMode::kDds);
  for (const SegmentationMode mode : {SegmentationMode::kAuto, SegmentationMode::kOnnx}) {
    const std::string name(to_string(mode));
    EXPECT_EQ(parse_segmentation(name)->mode, mode);
    EXPECT_TRUE(parse_segmentation(name)->onnx.model.empty());
    EXPECT_EQ(parse_segmentation(name + ":a:b.yaml")->mode, mode);
    EXPECT_EQ(parse_segmentation(name + ":a:b.yaml")->onnx.model, "a:b.yaml");
  }
  const auto left_only = parse_segmentation("masks:/data/left");
  ASSERT_TRUE(left_only.has_value());
  EXPECT_EQ(left_only->mode, SegmentationMode::kMasks);
  EXPECT_EQ(left_only->left_dir, "/data/left");
  EXPECT_TRUE(left_only->right_dir.empty());
  const auto both = parse_segmentation("masks:l,r");
  ASSERT_TRUE(both.has_value());
  EXPECT_EQ(both->left_dir, "l");
  EXPECT_EQ(both->right_dir, "r");
}

TEST(ParseSegmentation, NamesTheFormsForAnythingElse) {
  for (const char* text : {"", "mask:/data", "masks:", "masks:,r", "masks:l,", "masks:l,r,s", "masks", "Motion",
                           "motion:", "none:x", "auto:", "onnx:", ":"}) {
    const auto result = parse_segmentation(text);
    ASSERT_FALSE(result.has_value()) << text;
    EXPECT_EQ(result.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(result.error().message, HasSubstr("masks:LEFT_DIR[,RIGHT_DIR]"));
  }
}

TEST(ParseSegmentation, OffersTheNearestForm) {
  EXPECT_THAT(parse_segmentation("moton").error().message, HasSubstr("; did you mean motion?"));
  EXPECT_THAT(parse_segmentation("mask:/data").error().message, HasSubstr("; did you mean masks?"));
  EXPECT_THAT(parse_segmentation("telepathy").error().message, ::testing::Not(HasSubstr("did you mean")));
}

TEST(SegmentationConfig, FindsObjectsByAllThatThereIs) {
  EXPECT_EQ(SegmentationConfig{}.mode, SegmentationMode::kAuto);
}

TEST(SegmentationConfig, AcceptsItsDefaults) {
  EXPECT_TRUE(SegmentationConfig{}.validate().has_value());
}

TEST(SegmentationConfig, NamesTheKeyThatIsOutOfRange) {
  const auto message = [](auto change) {
    SegmentationConfig config;
    change(config);
    const Status status = config.validate();
    return status ? std::string() : status.error().message;
  };
  EXPECT_EQ(message([](auto& c) { c.max_objects = 65; }), "segmentation.max_objects must be in [1, 64], got 65");
  EXPECT_THAT(message([](auto& c) { c.mode = SegmentationMode::kMasks; }), HasSubstr("segmentation.left_dir"));
  EXPECT_THAT(message([](auto& c) { c.dds.timeout_ms = -1; }), HasSubstr("segmentation.dds.timeout_ms"));
  EXPECT_THAT(message([](auto& c) { c.dds.timeout_ms = 60'001; }), HasSubstr("segmentation.dds.timeout_ms"));
  EXPECT_THAT(message([](auto& c) { c.motion.memory_s = 0.0; }), HasSubstr("segmentation.motion.memory_s"));
  EXPECT_THAT(message([](auto& c) { c.motion.memory_s = 11.0; }), HasSubstr("segmentation.motion.memory_s"));
  EXPECT_THAT(message([](auto& c) { c.motion.sigma_px = std::nan(""); }), HasSubstr("segmentation.motion.sigma_px"));
  EXPECT_THAT(message([](auto& c) { c.motion.min_features = 1; }), HasSubstr("segmentation.motion.min_features"));
}

}  // namespace
}  // namespace kinetrace::segmentation

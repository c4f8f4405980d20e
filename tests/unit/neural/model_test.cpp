#include "kinetrace/neural/model.hpp"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::neural {
namespace {

ModelConfig good() {
  ModelConfig model;
  model.file = "model.onnx";
  model.classes = {{"car", kVehicleClass}};
  return model;
}

void expect_refused(const ModelConfig& model, const char* names) {
  const Status valid = model.validate();
  ASSERT_FALSE(valid);
  EXPECT_EQ(valid.error().code, ErrorCode::kInvalidConfig);
  EXPECT_THAT(valid.error().message, ::testing::HasSubstr(names));
}

TEST(ModelConfig, ItsDefaultsAreFine) {
  EXPECT_TRUE(good().validate());
}

TEST(ModelConfig, WhatCannotBeIsNamed) {
  ModelConfig model = good();
  model.file.clear();
  expect_refused(model, "model");
  model = good();
  model.classes.clear();
  expect_refused(model, "classes");
  model = good();
  model.input.width_px = 650;
  expect_refused(model, "multiples of 32");
  model = good();
  model.input.height_px = 16;
  expect_refused(model, "input.height");
  model = good();
  model.input.deviation[1] = 0.F;
  expect_refused(model, "input.std");
  model = good();
  model.classes[0].min_score = 1.5F;
  expect_refused(model, "thresholds.score");
  model = good();
  model.classes[0].calibration.slope = 0.F;
  expect_refused(model, "calibration.slope");
  model = good();
  model.classes[0].calibration.even = 1.F;
  expect_refused(model, "car: calibration.even");
}

TEST(ModelConfig, ASizeThatFollowsThePicturesIsForModelsThatCanHaveAny) {
  ModelConfig model = good();
  model.input.max_pixels = 100000;
  expect_refused(model, "kinetrace-seg");
  model.family = ModelFamily::kKinetraceSeg;
  EXPECT_TRUE(model.validate());
  model.input.max_pixels = 1000;
  expect_refused(model, "at least 1024");
  model.input.max_pixels = -1;
  expect_refused(model, "input.pixels");
}

TEST(ModelConfig, DisparitiesAreForNetworksMadeForThem) {
  ModelConfig model = good();
  model.input.colours = InputColours::kGray;
  model.input.disparity = true;
  EXPECT_EQ(model.input.channels(), 2);
  expect_refused(model, "input.disparity is for models of the family kinetrace-seg");
  model.family = ModelFamily::kKinetraceSeg;
  EXPECT_TRUE(model.validate());
}

TEST(ModelInput, FollowsThePicturesWithinItsPixels) {
  ModelInput input;
  input.max_pixels = 245760;
  struct Case {
    int width;
    int height;
    int input_width;
    int input_height;
  };
  for (const Case& one :
       {Case{1242, 375, 832, 256}, Case{752, 480, 576, 384}, Case{640, 480, 544, 416}, Case{480, 640, 416, 576},
        Case{320, 240, 320, 256}, Case{7, 5, 32, 32}, Case{20000, 10, 4096, 32}, Case{4000, 1, 4000, 32},
        Case{1, 4000, 32, 4096}, Case{1, 1, 32, 32}}) {
    const ModelInput sized = input.sized_for(one.width, one.height);
    EXPECT_EQ(sized.width_px, one.input_width) << one.width << "x" << one.height;
    EXPECT_EQ(sized.height_px, one.input_height) << one.width << "x" << one.height;
    EXPECT_LE(sized.width_px * sized.height_px, input.max_pixels);
  }
  input.max_pixels = 32 * 100;
  EXPECT_EQ(input.sized_for(1, 4000).height_px, 96);
}

TEST(ModelInput, ThatIsGivenStaysAsItIs) {
  const ModelInput sized = ModelInput{.width_px = 640, .height_px = 192}.sized_for(1242, 375);
  EXPECT_EQ(sized.width_px, 640);
  EXPECT_EQ(sized.height_px, 192);
}

TEST(ScoreCalibration, OfItselfTakesScoresForProbabilities) {
  const ScoreCalibration calibration;
  for (const float score : {0.01F, 0.3F, 0.5F, 0.99F}) {
    EXPECT_NEAR(calibration.probability(score), score, 1e-5F);
    EXPECT_NEAR(calibration.score(score), score, 1e-5F);
  }
}

TEST(ScoreCalibration, StretchesAndShiftsLogOdds) {
  const ScoreCalibration calibration{.slope = 2.F, .even = 0.2F};
  EXPECT_NEAR(calibration.probability(0.2F), 0.5F, 1e-5F);
  EXPECT_NEAR(calibration.probability(0.5F), 16.F / 17.F, 1e-5F) << "logit(.2) = -ln 4";
  EXPECT_NEAR(calibration.score(calibration.probability(0.3F)), 0.3F, 1e-4F);
  EXPECT_TRUE(std::isfinite(calibration.probability(0.F)));
  EXPECT_TRUE(std::isfinite(calibration.probability(1.F)));
}

TEST(ModelConfig, MaskRcnnMayHaveAnySize) {
  ModelConfig model = good();
  model.family = ModelFamily::kMaskRcnn;
  model.input.width_px = 650;
  EXPECT_TRUE(model.validate());
}

}  // namespace
}  // namespace kinetrace::neural

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
  model.thresholds.score = 1.5F;
  expect_refused(model, "thresholds.score");
  model = good();
  model.calibration.slope = 0.F;
  expect_refused(model, "calibration.slope");
  model = good();
  model.calibration.even = 1.F;
  expect_refused(model, "calibration.even");
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

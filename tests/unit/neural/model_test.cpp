#include "kinetrace/neural/model.hpp"

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
}

TEST(ModelConfig, MaskRcnnMayHaveAnySize) {
  ModelConfig model = good();
  model.family = ModelFamily::kMaskRcnn;
  model.input.width_px = 650;
  EXPECT_TRUE(model.validate());
}

}  // namespace
}  // namespace kinetrace::neural

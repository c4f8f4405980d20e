#include "segmentation/model_file.hpp"

#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "temp_folder.hpp"

namespace kinetrace::app {
namespace {

using neural::InputColours;
using neural::InputFit;
using neural::ModelClass;
using neural::ModelFamily;
using ::testing::HasSubstr;

class ModelFile : public ::testing::Test {
 protected:
  [[nodiscard]] Result<neural::ModelConfig> read(const std::string& text) const {
    std::ofstream(path()) << text;
    return load_model(path());
  }
  [[nodiscard]] std::filesystem::path path() const { return folder_.path() / "model.yaml"; }
  void expect_refused(const std::string& text, const std::string& says, int line = 0) const {
    const auto model = read(text);
    ASSERT_FALSE(model) << text;
    EXPECT_EQ(model.error().code, ErrorCode::kInvalidConfig);
    EXPECT_THAT(model.error().message, HasSubstr(says));
    std::string place = path().string();
    if (line > 0) {
      place.append(":").append(std::to_string(line));
    }
    EXPECT_THAT(model.error().message, HasSubstr(place));
  }

  test::TempFolder folder_;
};

constexpr const char* kGood = R"(family: yolov5-seg
model: net.onnx
input: {width: 640, height: 192, colours: bgr, fit: stretch, scale: 0.5, mean: [1, 2, 3], std: [4, 5, 6], pad: 0}
classes: [car, dog, person, sky]
use: {car: vehicle, person: person, sky: ignore}
thresholds: {score: 0.3, overlap: 0.6}
calibration: {slope: 1.5, even: 0.4}
)";

TEST_F(ModelFile, ANetworkOfRenderedPicturesIsForRenderedPicturesOnly) {
  const auto real = read(kGood);
  ASSERT_TRUE(real);
  EXPECT_EQ(model_caution(*real, folder_.path()), std::nullopt);

  const auto rendered = read(std::string(kGood) + "trained_on: rendered\n");
  ASSERT_TRUE(rendered) << rendered.error().message;
  const std::filesystem::path pictures = folder_.path() / "2026" / "drive" / "image_00" / "data";
  std::filesystem::create_directories(pictures);
  for (const std::filesystem::path& seen : {pictures, folder_.path(), std::filesystem::path()}) {
    EXPECT_THAT(model_caution(*rendered, seen).value_or(""), HasSubstr("net.onnx was trained on rendered pictures"));
  }
  // As kinetrace-simulate leaves it.
  std::filesystem::create_directories(folder_.path() / "truth");
  std::ofstream(folder_.path() / "truth" / "objects.csv").flush();
  for (const std::filesystem::path& seen : {pictures / "0.png", pictures, folder_.path()}) {
    EXPECT_EQ(model_caution(*rendered, seen), std::nullopt) << seen;
  }
  expect_refused(std::string(kGood) + "trained_on: dreams\n", "trained_on must be one of: real, rendered", 8);
}

TEST_F(ModelFile, SaysAllThatANetworkNeeds) {
  const auto model = read(kGood);
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_EQ(model->family, ModelFamily::kYolov5Seg);
  EXPECT_EQ(model->file, (folder_.path() / "net.onnx").string());
  EXPECT_EQ(model->graph, "");
  EXPECT_EQ(model->input.width_px, 640);
  EXPECT_EQ(model->input.height_px, 192);
  EXPECT_EQ(model->input.colours, InputColours::kBgr);
  EXPECT_EQ(model->input.fit, InputFit::kStretch);
  EXPECT_FLOAT_EQ(model->input.scale, 0.5F);
  EXPECT_FLOAT_EQ(model->input.mean[2], 3.F);
  EXPECT_FLOAT_EQ(model->input.deviation[0], 4.F);
  EXPECT_EQ(model->input.pad, 0);
  ASSERT_EQ(model->classes.size(), 4U);
  EXPECT_EQ(model->classes[0].class_id, kVehicleClass);
  EXPECT_EQ(model->classes[1].class_id, ModelClass::kDropped);
  EXPECT_EQ(model->classes[2].class_id, kPedestrianClass);
  EXPECT_EQ(model->classes[3].class_id, kIgnoreClass);
  EXPECT_FLOAT_EQ(model->classes[0].min_score, 0.3F);
  EXPECT_FLOAT_EQ(model->thresholds.overlap, 0.6F);
  EXPECT_FLOAT_EQ(model->classes[0].calibration.slope, 1.5F);
  EXPECT_FLOAT_EQ(model->classes[0].calibration.even, 0.4F);
}

TEST_F(ModelFile, WhatIsNotSaidIsAsExportersHaveIt) {
  const auto model = read("model: /nets/net.onnx\nclasses: [car]\nuse: {car: vehicle}\n");
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_EQ(model->family, ModelFamily::kYolov8Seg);
  EXPECT_EQ(model->file, "/nets/net.onnx");
  EXPECT_EQ(model->input.width_px, 640);
  EXPECT_EQ(model->input.colours, InputColours::kRgb);
  EXPECT_FLOAT_EQ(model->input.scale, 1.F / 255.F);
  EXPECT_FLOAT_EQ(model->classes[0].calibration.slope, 2.F);
  EXPECT_FLOAT_EQ(model->classes[0].calibration.even, model->classes[0].min_score);
}

TEST_F(ModelFile, EachClassMayHaveACalibrationOfItsOwn) {
  const auto model = read(
      "model: n.onnx\nclasses: [car, man]\nuse: {car: vehicle, man: person}\n"
      "calibration: {man: {slope: 1.5, even: 0.3}}\n");
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_FLOAT_EQ(model->classes[0].calibration.slope, 2.F);
  EXPECT_FLOAT_EQ(model->classes[0].min_score, 0.25F);
  EXPECT_FLOAT_EQ(model->classes[1].calibration.slope, 1.5F);
  EXPECT_FLOAT_EQ(model->classes[1].calibration.even, 0.3F);
  EXPECT_FLOAT_EQ(model->classes[1].min_score, 0.3F) << "as probable as not";
}

TEST_F(ModelFile, UnusedClassesMayShareAName) {
  const auto model = read("model: n.onnx\nclasses: [N/A, car, N/A]\nuse: {car: vehicle}\n");
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_EQ(model->classes.size(), 3U);
  EXPECT_EQ(model->classes[1].class_id, kVehicleClass);
}

TEST_F(ModelFile, ACalibrationOfNoClassIsRefused) {
  const auto model = read("model: n.onnx\nclasses: [car]\nuse: {car: vehicle}\ncalibration: {dog: {slope: 1}}\n");
  ASSERT_FALSE(model);
  EXPECT_THAT(model.error().message, HasSubstr("calibration.dog"));
  EXPECT_THAT(model.error().message, HasSubstr("there are: car"));
}

TEST_F(ModelFile, TheSizeOfItsInputMayFollowThePictures) {
  const auto model =
      read("family: kinetrace-seg\nmodel: net.onnx\nclasses: [car]\nuse: {car: vehicle}\ninput: {pixels: 245760}\n");
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_EQ(model->family, ModelFamily::kKinetraceSeg);
  EXPECT_EQ(model->input.max_pixels, 245760);
}

TEST_F(ModelFile, DisparitiesMayBeAChannel) {
  const auto model = read(
      "family: kinetrace-seg\nmodel: net.onnx\nclasses: [car]\nuse: {car: vehicle}\n"
      "input: {pixels: 245760, colours: gray, mean: [0], disparity: true}\n");
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_TRUE(model->input.disparity);
  EXPECT_EQ(model->input.channels(), 2);
}

TEST_F(ModelFile, WhatIsWrongIsNamedWithItsLine) {
  expect_refused("input: {disparity: 1}\n", "disparity must be one of: true, false", 1);
  expect_refused("model: a\nmodell: b\n", "unknown key \"modell\"", 2);
  expect_refused("model: a\nmodel: b\n", "already given in line 1", 2);
  expect_refused("family: yolov9\n",
                 "family must be one of: yolov5-seg, yolov8-seg, yolo11-seg, kinetrace-seg, mask-rcnn", 1);
  expect_refused("input: {colour: rgb}\n", "unknown key \"input.colour\"", 1);
  expect_refused("input: [1]\n", "section", 1);
  expect_refused("classes: [car]\nuse: {car: vehicle}\ncalibration: {scale: 1}\n", "unknown key \"calibration.scale\"",
                 3);
  expect_refused("input: {width: wide}\n", "width must be a whole number", 1);
  expect_refused("input: {width: 640.5}\n", "whole number", 1);
  expect_refused("input: {pixels: 100000, width: 640}\n", "give that, or width and height", 1);
  expect_refused("model: a\nclasses: [car]\nuse: {car: vehicle}\ninput: {pixels: 100000}\n", "kinetrace-seg");
  expect_refused("input: {scale: .nan}\n", "finite number", 1);
  expect_refused("input: {mean: [1, 2]}\n", "list of 3 numbers", 1);
  expect_refused("input: {colours: gray, mean: [1, 2, 3]}\n", "list of 1 numbers", 1);
  expect_refused("input: {pixels: 99999999999}\n", "pixels must be within -1e9 and 1e9, got 99999999999", 1);
  expect_refused("classes: [car]\nuse: {car: vehicle}\ncalibration: {slope: 1e30}\n",
                 "slope must be within -1e9 and 1e9, got 1e30", 3);
  expect_refused("classes: car\n", "list of names", 1);
  expect_refused("classes: [\"\", car]\nuse: {car: vehicle}\n", "class 0 has no name", 1);
  expect_refused("classes: [car, [dog]]\nuse: {car: vehicle}\n", "class 1 has no name", 1);
  expect_refused("classes: [car, dog, car]\nuse: {car: vehicle}\n", "several classes are named \"car\"", 2);
  expect_refused("classes: [car]\nuse: {dog: vehicle}\n", "\"dog\" is none of the classes", 2);
  expect_refused("classes: [car]\nuse: {car: truck}\n", "car must be one of: vehicle, person, ignore, drop", 2);
  expect_refused("classes: [car]\n", "at least one class");
  expect_refused("{", "not valid YAML");
  expect_refused("just words", "expected lines");
  expect_refused("classes: [car]\nuse: {car: vehicle}\n", "model must name");
  expect_refused("model: a\nclasses: [car]\nuse: {car: vehicle}\ninput: {width: 650}\n", "multiples of 32");
}

TEST_F(ModelFile, ANetworkInsteadOfItsDescriptionIsRecognised) {
  const std::filesystem::path network = folder_.path() / "net.onnx";
  std::ofstream(network) << "\x08\x07";
  const auto model = load_model(network);
  EXPECT_EQ(model.error().code, ErrorCode::kInvalidConfig);
  EXPECT_THAT(model.error().message, HasSubstr("write a YAML file beside"));
}

TEST_F(ModelFile, WhereThereIsNoneItSaysSo) {
  EXPECT_EQ(load_model(folder_.path() / "other.yaml").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace kinetrace::app

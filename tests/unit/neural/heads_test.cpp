#include "heads.hpp"

#include <array>
#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::neural {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 64;
constexpr int kHeight = 32;
constexpr int kMasks = 2;
constexpr int kCells8 = 8 * 4;
constexpr int kCells16 = 4 * 2;
constexpr int kCells32 = 2 * 1;
constexpr int kCells = kCells8 + kCells16 + kCells32;

/// Tensors of one value, zero by default, that tests write into.
class Heads : public ::testing::Test {
 protected:
  Heads() {
    model_.file = "model.onnx";
    model_.input.width_px = kWidth;
    model_.input.height_px = kHeight;
    model_.classes = {
        {"car", kVehicleClass, 0.5F}, {"dog", ModelClass::kDropped, 0.5F}, {"person", kPedestrianClass, 0.5F}};
  }
  std::vector<float>& output(const std::vector<int>& sizes, float value = 0.F) {
    std::size_t count = 1;
    Tensor tensor;
    for (const int size : sizes) {
      tensor.sizes[tensor.rank++] = size;
      count *= static_cast<std::size_t>(size);
    }
    values_.push_back(std::make_unique<std::vector<float>>(count, value));
    tensor.values = *values_.back();
    outputs_.push_back(tensor);
    return *values_.back();
  }
  void prototypes() { output({1, kMasks, kHeight / 4, kWidth / 4}); }
  std::span<const Candidate> decoded() {
    const Result<HeadLayout> layout = HeadLayout::find(model_, outputs_);
    EXPECT_TRUE(layout) << layout.error().message;
    candidates_.clear();
    decode(*layout, model_, outputs_, candidates_);
    return candidates_.all();
  }
  void expect_box(const Box& box, const Box& expected) {
    EXPECT_NEAR(box.x0, expected.x0, 1e-3);
    EXPECT_NEAR(box.y0, expected.y0, 1e-3);
    EXPECT_NEAR(box.x1, expected.x1, 1e-3);
    EXPECT_NEAR(box.y1, expected.y1, 1e-3);
  }

  ModelConfig model_;
  std::vector<std::unique_ptr<std::vector<float>>> values_;
  std::vector<Tensor> outputs_;
  Arena arena_{1 << 20};
  CandidateList candidates_{arena_, 64};
};

TEST_F(Heads, ExportedColumns) {
  prototypes();
  std::vector<float>& values = output({1, 4 + 3 + kMasks, kCells});
  const auto set = [&](std::size_t row, std::size_t column, float value) { values[row * kCells + column] = value; };
  for (const auto& [row, value] : std::vector<std::pair<std::size_t, float>>{
           {0, 30.F}, {1, 10.F}, {2, 20.F}, {3, 8.F}, {4, 0.1F}, {6, 0.8F}, {7, 3.F}, {8, -4.F}}) {
    set(row, 5, value);
  }
  set(5, 9, 0.9F);  // A dog.
  const auto found = decoded();
  ASSERT_EQ(found.size(), 1U);
  expect_box(found[0].box, {20, 6, 40, 14});
  EXPECT_FLOAT_EQ(found[0].score, 0.8F);
  EXPECT_EQ(found[0].class_index, 2);
  EXPECT_FLOAT_EQ(found[0].mask[0], 3.F);
  EXPECT_FLOAT_EQ(found[0].mask[1], -4.F);
}

TEST_F(Heads, ProposesWeakerOnesIfAskedToButForWhatIsToBeIgnored) {
  model_.classes.push_back({"sky", kIgnoreClass, 0.5F});
  prototypes();
  std::vector<float>& values = output({1, 4 + 4 + kMasks, kCells});
  for (std::size_t column = 0; column < 4; ++column) {
    const std::array<float, 4> box{30.F, 10.F, 20.F, 8.F};
    for (std::size_t row = 0; row < box.size(); ++row) {
      values[row * kCells + column] = box[row];
    }
  }
  values[4 * kCells + 0] = 0.3F;
  values[4 * kCells + 1] = 0.2F;  // Below the threshold anyway.
  values[7 * kCells + 2] = 0.3F;
  values[7 * kCells + 3] = 0.6F;
  EXPECT_EQ(decoded().size(), 1U) << "the sky alone";
  model_.thresholds.proposal = 0.25F;
  EXPECT_EQ(decoded().size(), 2U);
  model_.thresholds.proposal = 0.9F;
  EXPECT_EQ(decoded().size(), 1U) << "never fewer";
}

TEST_F(Heads, EachClassHasAScoreOfItsOwn) {
  prototypes();
  std::vector<float>& values = output({1, 4 + 3 + kMasks, kCells});
  const std::array<float, 4> box{30.F, 10.F, 20.F, 8.F};
  for (std::size_t column = 0; column < 2; ++column) {
    for (std::size_t row = 0; row < box.size(); ++row) {
      values[row * kCells + column] = box[row];
    }
  }
  values[4 * kCells + 0] = 0.4F;  // A car.
  values[6 * kCells + 1] = 0.4F;  // A person.
  EXPECT_TRUE(decoded().empty());
  model_.classes[2].min_score = 0.3F;
  ASSERT_EQ(decoded().size(), 1U);
  EXPECT_EQ(decoded()[0].class_index, 2);
  model_.classes[2].min_score = 0.5F;
  model_.classes[0].calibration.even = 0.3F;
  model_.thresholds.proposal = 0.5F;
  ASSERT_EQ(decoded().size(), 1U) << "more probable than not";
  EXPECT_EQ(decoded()[0].class_index, 0);
}

TEST_F(Heads, ExportedRows) {
  model_.family = ModelFamily::kYolov5Seg;
  std::vector<float>& values = output({1, 3 * kCells, 5 + 3 + kMasks});
  prototypes();
  const std::vector<float> row{30.F, 10.F, 20.F, 8.F, 0.9F, 0.7F, 0.2F, 0.1F, 3.F, -4.F};
  std::copy(row.begin(), row.end(), values.begin() + 70);
  const std::vector<float> weak{30.F, 10.F, 20.F, 8.F, 0.6F, 0.7F, 0.2F, 0.1F, 3.F, -4.F};
  std::copy(weak.begin(), weak.end(), values.begin() + 90);
  const auto found = decoded();
  ASSERT_EQ(found.size(), 1U) << "0.6 * 0.7 is below 0.5";
  expect_box(found[0].box, {20, 6, 40, 14});
  EXPECT_FLOAT_EQ(found[0].score, 0.63F);
  EXPECT_FLOAT_EQ(found[0].mask[1], -4.F);
}

TEST_F(Heads, RawDistanceMaps) {
  output({1, 64 + 3, kHeight / 8, kWidth / 8}, -20.F);
  std::vector<float>& level16 = output({1, 64 + 3, kHeight / 16, kWidth / 16}, -20.F);
  output({1, 64 + 3, kHeight / 32, kWidth / 32}, -20.F);
  std::vector<float>& coefficients = output({1, kMasks, kCells});
  prototypes();
  // The cell at column 2, row 1 of the level of stride 16: 1 cell to the left, 0.5 up, 2 right, 0 down.
  constexpr std::size_t kCell = 1 * 4 + 2;
  const auto set = [&](std::size_t channel, float value) { level16[channel * kCells16 + kCell] = value; };
  for (std::size_t channel = 0; channel < 64; ++channel) {
    set(channel, -50.F);
  }
  set(0 * 16 + 1, 50.F);
  set(1 * 16 + 0, 50.F);
  set(1 * 16 + 1, 50.F);
  set(2 * 16 + 2, 50.F);
  set(3 * 16 + 0, 50.F);
  set(64, 2.F);
  coefficients[kCells8 + kCell] = 5.F;
  coefficients[kCells + kCells8 + kCell] = 6.F;
  const auto found = decoded();
  ASSERT_EQ(found.size(), 1U);
  expect_box(found[0].box, {24, 16, 72, 24});
  EXPECT_NEAR(found[0].score, 1.F / (1.F + std::exp(-2.F)), 1e-5);
  EXPECT_FLOAT_EQ(found[0].mask[0], 5.F);
  EXPECT_FLOAT_EQ(found[0].mask[1], 6.F);
}

TEST_F(Heads, CellMaps) {
  model_.family = ModelFamily::kKinetraceSeg;
  output({1, 4 + 3 + kMasks, kHeight / 8, kWidth / 8});
  std::vector<float>& level16 = output({1, 4 + 3 + kMasks, kHeight / 16, kWidth / 16});
  output({1, 4 + 3 + kMasks, kHeight / 32, kWidth / 32});
  prototypes();
  // The cell at column 2, row 1 of the level of stride 16, whose middle is at (40, 24).
  constexpr std::size_t kCell = 1 * 4 + 2;
  std::size_t channel = 0;
  for (const float value : {16.F, 8.F, 32.F, 1.F, 0.1F, 0.2F, 0.8F, 5.F, 6.F}) {
    level16[channel++ * kCells16 + kCell] = value;
  }
  const auto found = decoded();
  ASSERT_EQ(found.size(), 1U);
  expect_box(found[0].box, {24, 16, 72, 25});
  EXPECT_FLOAT_EQ(found[0].score, 0.8F);
  EXPECT_EQ(found[0].class_index, 2);
  EXPECT_FLOAT_EQ(found[0].mask[0], 5.F);
  EXPECT_FLOAT_EQ(found[0].mask[1], 6.F);
}

TEST_F(Heads, RawAnchorMaps) {
  model_.family = ModelFamily::kYolov5Seg;
  constexpr int kLength = 5 + 3 + kMasks;
  output({1, 3, kHeight / 8, kWidth / 8, kLength}, -20.F);
  std::vector<float>& level16 = output({1, 3, kHeight / 16, kWidth / 16, kLength}, -20.F);
  output({1, 3, kHeight / 32, kWidth / 32, kLength}, -20.F);
  prototypes();
  // The second anchor, 62 x 45, at column 2, row 1: sigmoid(0) = 1/2 puts the centre into the middle and leaves the
  // size.
  const std::vector<float> row{0.F, 0.F, 0.F, 0.F, 10.F, -20.F, -20.F, 10.F, 3.F, -4.F};
  std::copy(row.begin(), row.end(), level16.begin() + std::ptrdiff_t{1 * kCells16 + 1 * 4 + 2} * kLength);
  const auto found = decoded();
  ASSERT_EQ(found.size(), 1U);
  expect_box(found[0].box, {40 - 31, 24 - 22.5F, 40 + 31, 24 + 22.5F});
  EXPECT_EQ(found[0].class_index, 2);
  EXPECT_FLOAT_EQ(found[0].mask[0], 3.F);
}

TEST_F(Heads, PrototypesMayHaveHalfTheSizeOfTheInput) {
  model_.family = ModelFamily::kKinetraceSeg;
  constexpr int kChannels = 4 + 3 + kMasks;
  for (const int stride : {8, 16, 32}) {
    output({1, kChannels, kHeight / stride, kWidth / stride});
  }
  output({1, kMasks, kHeight / 2, kWidth / 2});
  const Result<HeadLayout> layout = HeadLayout::find(model_, outputs_);
  ASSERT_TRUE(layout) << layout.error().message;
  EXPECT_EQ(layout->masks, 3U);
  EXPECT_EQ(layout->prototype_stride_px, 2);
  EXPECT_EQ(layout->mask_width, kWidth / 2);
}

TEST_F(Heads, DetectionsOfMaskRcnn) {
  model_.family = ModelFamily::kMaskRcnn;
  std::vector<float>& rows = output({1, 1, 3, 7});
  std::vector<float>& masks = output({3, 3, 2, 2});
  const std::vector<float> second{0.F, 2.F, 0.75F, 0.25F, 0.5F, 0.5F, 1.F};
  std::copy(second.begin(), second.end(), rows.begin() + 7);
  rows[2 * 7 + 1] = 9.F;  // An unknown class.
  rows[2 * 7 + 2] = 1.F;
  masks[(1 * 3 + 2) * 4 + 3] = 0.6F;
  const auto found = decoded();
  ASSERT_EQ(found.size(), 1U);
  expect_box(found[0].box, {16, 16, 32, 32});
  EXPECT_FLOAT_EQ(found[0].mask[3], 0.6F);
}

TEST_F(Heads, OutputsThatFitNothingAreNamedWithTheExport) {
  output({1, 10});
  const Result<HeadLayout> layout = HeadLayout::find(model_, outputs_);
  EXPECT_EQ(layout.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(layout.error().message, HasSubstr("[1, 10]"));
  EXPECT_THAT(layout.error().message, HasSubstr("yolo export"));
  outputs_.clear();
  EXPECT_THAT(HeadLayout::find(model_, outputs_).error().message, HasSubstr("none"));
}

TEST_F(Heads, AnotherNumberOfClassesIsRefused) {
  prototypes();
  output({1, 4 + 80 + kMasks, kCells});
  const Result<HeadLayout> layout = HeadLayout::find(model_, outputs_);
  EXPECT_EQ(layout.error().code, ErrorCode::kInvalidConfig);
  EXPECT_THAT(layout.error().message, HasSubstr("80 classes"));
  EXPECT_THAT(layout.error().message, HasSubstr("names 3"));
}

TEST_F(Heads, AnotherInputSizeIsRefused) {
  prototypes();
  output({1, 4 + 3 + kMasks, kCells + 1});
  EXPECT_EQ(HeadLayout::find(model_, outputs_).error().code, ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace kinetrace::neural

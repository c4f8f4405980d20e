#include "kinetrace/evaluation/similarity.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "kinetrace/evaluation/object_metrics.hpp"

namespace kinetrace::evaluation {
namespace {

constexpr int kWidth = 10;
constexpr int kHeight = 4;

ObjectFrame frame_of(const std::vector<std::uint32_t>& objects, const std::vector<std::uint32_t>& tracks) {
  ObjectFrame frame;
  for (const std::uint32_t id : objects) {
    frame.truth.emplace_back().id = id;
  }
  for (const std::uint32_t id : tracks) {
    frame.tracks.emplace_back().track_id = id;
  }
  return frame;
}

std::vector<std::uint8_t> columns(int x0, int x1, std::uint8_t label) {
  std::vector<std::uint8_t> labels(std::size_t{kWidth} * kHeight, 0);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = x0; x < x1; ++x) {
      labels[static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x)] = label;
    }
  }
  return labels;
}

LabelView view(const std::vector<std::uint8_t>& labels) {
  return {labels.data(), kWidth, kHeight, kWidth};
}

TEST(BoxIou, IsThePartThatBothShare) {
  EXPECT_DOUBLE_EQ(box_iou({0, 0, 10, 10}, {0, 0, 10, 10}), 1.0);
  EXPECT_DOUBLE_EQ(box_iou({0, 0, 10, 10}, {5, 0, 15, 10}), 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(box_iou({0, 0, 10, 10}, {10, 0, 20, 10}), 0.0);
  EXPECT_DOUBLE_EQ(box_iou({}, {}), 0.0);
}

TEST(CompareMasks, KnowsTracksByTheirMasks) {
  const std::vector<std::uint8_t> truth = columns(0, 6, 3);
  const std::vector<std::uint8_t> result = columns(2, 8, 9);
  const std::vector<MaskInstance> objects{{3, 7, 1}};
  const std::vector<MaskInstance> tracks{{9, 21, 1}};
  ObjectFrame frame = frame_of({5, 7}, {20, 21});
  ASSERT_TRUE(compare_masks({view(truth), objects}, {view(result), tracks}, {}, frame));
  EXPECT_DOUBLE_EQ(frame.similarity(1, 1), 0.5);
  EXPECT_DOUBLE_EQ(frame.similarity.sum(), 0.5);
  EXPECT_EQ(frame.tracks[0].covers, -1);
  EXPECT_EQ(frame.tracks[1].covers, 1);  // Four of its six columns.
}

TEST(CompareMasks, TakesTheBoxOfATrackWithoutMask) {
  const std::vector<std::uint8_t> truth = columns(0, 6, 3);
  const std::vector<MaskInstance> objects{{3, 7, 1}};
  ObjectFrame frame = frame_of({7}, {20, 21});
  const std::vector<ImageBox> boxes{{}, {0, 0, 6, 2}};
  ASSERT_TRUE(compare_masks({view(truth), objects}, {}, boxes, frame));
  EXPECT_DOUBLE_EQ(frame.similarity(0, 0), 0.0);
  EXPECT_DOUBLE_EQ(frame.similarity(0, 1), 0.5);
}

TEST(CompareMasks, RefusesImagesOfDifferentSize) {
  const std::vector<std::uint8_t> labels = columns(0, 1, 3);
  const std::vector<MaskInstance> instances{{3, 7, 1}};
  ObjectFrame frame = frame_of({7}, {7});
  const Status compared = compare_masks({view(labels), instances}, {{labels.data(), 5, 8, 5}, instances}, {}, frame);
  ASSERT_FALSE(compared);
  EXPECT_EQ(compared.error().code, ErrorCode::kInvalidArgument);
}

TEST(CompareCentres, IsHalfAtTheGate) {
  ObjectFrame frame = frame_of({1, 2}, {3, 4});
  constexpr double kNowhere = std::numeric_limits<double>::infinity();
  compare_centres({{0, 0, 0}, {0, 0, 9}}, {{0, 0, 3}, Eigen::Vector3d::Constant(kNowhere)}, 3.0, frame);
  EXPECT_DOUBLE_EQ(frame.similarity(0, 0), 0.5);
  EXPECT_DOUBLE_EQ(frame.similarity(1, 0), 0.0);
  EXPECT_DOUBLE_EQ(frame.similarity(0, 1), 0.0);
}

TEST(CompareBoxes, FillsObjectsByTracks) {
  ObjectFrame frame = frame_of({1}, {3, 4});
  compare_boxes({{0, 0, 2, 2}}, {{0, 0, 2, 1}, {0, 0, 2, 2}}, frame);
  EXPECT_DOUBLE_EQ(frame.similarity(0, 0), 0.5);
  EXPECT_DOUBLE_EQ(frame.similarity(0, 1), 1.0);
}

}  // namespace
}  // namespace kinetrace::evaluation

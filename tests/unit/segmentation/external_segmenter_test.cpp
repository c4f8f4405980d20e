// Masks from an external source: requests of the segmenter, and its use of the answers.
#include "kinetrace/segmentation/external_segmenter.hpp"

#include <filesystem>
#include <memory>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/segmentation/segmenter.hpp"

namespace kinetrace::segmentation {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr int kWidth = 20;
constexpr int kHeight = 10;
constexpr StereoGeometry kGeometry{.fx_px = 100.0,
                                   .fy_px = 100.0,
                                   .cx_px = 10.0,
                                   .cy_px = 5.0,
                                   .baseline_m = 0.5,
                                   .width_px = kWidth,
                                   .height_px = kHeight};

/// Answers with a test's masks.
class ScriptedSource final : public MaskSource {
 public:
  void request(const RectifiedPair& pair) noexcept override { requests.push_back(pair.frame_index); }
  [[nodiscard]] const MaskSet* await(std::int64_t frame_index) noexcept override {
    awaited.push_back(frame_index);
    return has_masks ? &masks : nullptr;
  }

  std::vector<std::int64_t> requests;
  std::vector<std::int64_t> awaited;
  bool has_masks = true;
  MaskSet masks;
};

class ExternalSegmenterTest : public ::testing::Test {
 protected:
  ExternalSegmenterTest() {
    config_.mode = SegmentationMode::kDds;
    config_.min_area_px = 1;
  }
  Segmenter& make() {
    arena_ = std::make_unique<Arena>(required_bytes(config_, kGeometry, 100));
    segmenter_ = make_segmenter(config_, kGeometry, 100, *arena_, {.external = &source_, .network = nullptr}).value();
    return *segmenter_;
  }
  DetectionFrame run(Segmenter& segmenter, std::int64_t index = 0) {
    SegmentationInput input;
    input.pair.frame_index = index;
    segmenter.load(input.pair, {});
    return segmenter.process(input).value();
  }
  /// A full rectangle.
  RunLengthMask rectangle(PixelBox box, std::uint16_t class_id = kVehicleClass, float score = 1.F) {
    runs_.push_back(std::make_unique<std::vector<std::uint16_t>>(
        std::vector<std::uint16_t>{0, static_cast<std::uint16_t>(box.width() * box.height())}));
    return {class_id, score, box, *runs_.back()};
  }

  SegmentationConfig config_;
  ScriptedSource source_;
  std::unique_ptr<Arena> arena_;
  std::unique_ptr<Segmenter> segmenter_;
  std::vector<std::unique_ptr<std::vector<std::uint16_t>>> runs_;
};

TEST_F(ExternalSegmenterTest, AsksEarlyAndTakesLate) {
  Segmenter& segmenter = make();
  SegmentationInput input;
  input.pair.frame_index = 7;
  segmenter.load(input.pair, {});
  EXPECT_THAT(source_.requests, ElementsAre(7));
  EXPECT_TRUE(source_.awaited.empty());
  ASSERT_TRUE(segmenter.process(input));
  EXPECT_THAT(source_.awaited, ElementsAre(7));
}

TEST_F(ExternalSegmenterTest, DrawsRunsRowByRowWithinTheBox) {
  // A box of 4 x 3 at (2, 1): one pixel outside, six inside over a row's end, the rest outside.
  const std::vector<std::uint16_t> runs{1, 6, 5};
  const std::vector<RunLengthMask> masks{{kPedestrianClass, 0.5F, {2, 1, 6, 4}, runs}};
  source_.masks.left = masks;
  const DetectionFrame frame = run(make());
  ASSERT_TRUE(frame.available);
  ASSERT_EQ(frame.left.size(), 1U);
  EXPECT_EQ(frame.left[0].class_id, kPedestrianClass);
  EXPECT_EQ(frame.left[0].score, 0.5F);
  EXPECT_EQ(frame.left[0].area_px, 6);
  std::vector<std::pair<int, int>> inside;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (frame.left_labels.at(x, y) != kBackgroundLabel) {
        inside.emplace_back(x, y);
      }
    }
  }
  EXPECT_THAT(inside, ElementsAre(std::pair(3, 1), std::pair(4, 1), std::pair(5, 1), std::pair(2, 2), std::pair(3, 2),
                                  std::pair(4, 2)));
  EXPECT_TRUE(frame.right_labels.empty());
}

TEST_F(ExternalSegmenterTest, TheEarlierMaskLiesAboveTheLater) {
  const std::vector<RunLengthMask> masks{rectangle({0, 0, 4, 4}, kPedestrianClass), rectangle({2, 0, 12, 4})};
  source_.masks.left = masks;
  const DetectionFrame frame = run(make());
  ASSERT_EQ(frame.left.size(), 2U);
  EXPECT_EQ(frame.left[0].class_id, kVehicleClass) << "larger, so first";
  EXPECT_EQ(frame.left[0].area_px, 32) << "without what is hidden";
  EXPECT_EQ(frame.left[1].area_px, 16);
  EXPECT_EQ(frame.left_labels.at(3, 0), frame.left[1].label);
}

TEST_F(ExternalSegmenterTest, IgnoredRegionsBelongToNoObject) {
  const std::vector<RunLengthMask> masks{rectangle({0, 0, 5, 5}, kIgnoreClass)};
  source_.masks.left = masks;
  const DetectionFrame frame = run(make());
  EXPECT_TRUE(frame.available);
  EXPECT_TRUE(frame.left.empty());
  EXPECT_EQ(frame.left_labels.at(4, 4), kIgnoreLabel);
  EXPECT_EQ(frame.left_labels.at(5, 4), kBackgroundLabel);
}

TEST_F(ExternalSegmenterTest, ForgetsTheMasksOfTheFrameBefore) {
  const std::vector<RunLengthMask> masks{rectangle({0, 0, 5, 5})};
  source_.masks.left = masks;
  Segmenter& segmenter = make();
  EXPECT_EQ(run(segmenter, 0).left.size(), 1U);
  source_.masks.left = {};
  const DetectionFrame empty = run(segmenter, 1);
  EXPECT_TRUE(empty.available) << "nothing is there, says somebody";
  EXPECT_TRUE(empty.left.empty());
  EXPECT_EQ(empty.left_labels.at(0, 0), kBackgroundLabel);
}

TEST_F(ExternalSegmenterTest, AFrameWithoutAnswerHasNoDetectionsAndIsCounted) {
  source_.has_masks = false;
  Segmenter& segmenter = make();
  EXPECT_FALSE(run(segmenter).available);
  EXPECT_EQ(segmenter.counters().frames, 1U);
  EXPECT_EQ(segmenter.counters().frames_missing, 1U);
}

TEST_F(ExternalSegmenterTest, TakesTheRightImageWhereItIsAskedFor) {
  config_.dds.right = true;
  const std::vector<RunLengthMask> left{rectangle({0, 0, 5, 5})};
  const std::vector<RunLengthMask> right{rectangle({1, 1, 3, 3}), rectangle({10, 1, 13, 3})};
  source_.masks = {left, right};
  const DetectionFrame frame = run(make());
  ASSERT_EQ(frame.right.size(), 2U);
  EXPECT_EQ(frame.right_labels.at(10, 1), frame.right[0].label);
}

TEST_F(ExternalSegmenterTest, DropsAndCountsWhatIsTooMany) {
  config_.max_objects = 2;
  std::vector<RunLengthMask> masks;
  for (int i = 0; i < 3; ++i) {
    masks.push_back(rectangle({4 * i, 0, 4 * i + 2 + (i == 2 ? 1 : 0), 2}));
  }
  source_.masks.left = masks;
  Segmenter& segmenter = make();
  EXPECT_EQ(run(segmenter).left.size(), 2U);
  EXPECT_EQ(segmenter.counters().detections_dropped, 1U);

  // One more than the maximum.
  masks.assign(MaskCanvas::kMaxMasks, rectangle({0, 0, 1, 1}));
  masks.push_back(rectangle({5, 5, 9, 9}));
  source_.masks.left = masks;
  EXPECT_EQ(run(segmenter, 1).left_labels.at(5, 5), kBackgroundLabel);
  EXPECT_EQ(segmenter.counters().detections_dropped, 2U);
}

TEST_F(ExternalSegmenterTest, WantsEachFrameLoaded) {
  Segmenter& segmenter = make();
  run(segmenter, 5);
  SegmentationInput next;
  next.pair.frame_index = 6;
  EXPECT_EQ(segmenter.process(next).error().code, ErrorCode::kIllegalState);
  segmenter.reset();
  next.pair.frame_index = 5;
  EXPECT_EQ(segmenter.process(next).error().code, ErrorCode::kIllegalState);
}

TEST_F(ExternalSegmenterTest, NeedsASourceAndExactlyTheBytesItAnnounces) {
  config_.dds.right = true;
  const std::size_t bytes = required_bytes(config_, kGeometry, 100);
  Arena enough(bytes);
  ASSERT_TRUE(make_segmenter(config_, kGeometry, 100, enough, {.external = &source_, .network = nullptr}));
  EXPECT_EQ(enough.used_bytes(), bytes);
  Arena too_small(bytes - 1);
  EXPECT_EQ(make_segmenter(config_, kGeometry, 100, too_small, {.external = &source_, .network = nullptr}).error().code,
            ErrorCode::kCapacity);
  Arena other(bytes);
  const auto without = make_segmenter(config_, kGeometry, 100, other);
  ASSERT_FALSE(without);
  EXPECT_EQ(without.error().code, ErrorCode::kInvalidConfig);
  EXPECT_THAT(without.error().message, HasSubstr("kinetrace run --publish"));
}

TEST(RunLengthMask, FitsOnlyWithItsBoxInTheImageAndItsRunsInTheBox) {
  const std::vector<std::uint16_t> eight{3, 5};
  const auto with_box = [&](PixelBox box) { return fits({1, 1.F, box, eight}, kWidth, kHeight); };
  EXPECT_TRUE(with_box({0, 0, 4, 2}));
  EXPECT_TRUE(with_box({kWidth - 4, kHeight - 2, kWidth, kHeight}));
  EXPECT_FALSE(with_box({0, 0, 3, 3})) << "one pixel more than runs";
  EXPECT_FALSE(with_box({0, 0, 7, 1})) << "one less";
  EXPECT_FALSE(with_box({kWidth - 3, 0, kWidth + 1, 2}));
  EXPECT_FALSE(with_box({-1, 0, 3, 2}));
  EXPECT_FALSE(with_box({0, kHeight - 1, 4, kHeight + 1}));
  EXPECT_FALSE(with_box({4, 2, 0, 0})) << "inside out";
  EXPECT_FALSE(fits({1, 1.F, {0, 0, 4, 2}, {}}, kWidth, kHeight)) << "no runs";
}

}  // namespace
}  // namespace kinetrace::segmentation

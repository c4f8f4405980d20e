#include "kinetrace/segmentation/network_segmenter.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::segmentation {
namespace {

constexpr StereoGeometry kGeometry{
    .fx_px = 100.0, .fy_px = 100.0, .cx_px = 32.0, .cy_px = 24.0, .baseline_m = 0.5, .width_px = 64, .height_px = 48};

/// Finishes on a test's command.
class ScriptedNetwork final : public DelayedMaskSource {
 public:
  void offer(const RectifiedPair& pair, const PixelBox& region_px) noexcept override {
    offered.push_back(pair.frame_index);
    regions_px.push_back(region_px);
  }
  [[nodiscard]] DelayedMasks take() noexcept override {
    ++asked;
    return {is_done, is_done && !fails ? &masks : nullptr};
  }

  std::vector<std::int64_t> offered;
  std::vector<PixelBox> regions_px;
  int asked = 0;
  bool is_done = true;
  bool fails = false;
  MaskSet masks;
};

class NetworkSegmenterTest : public ::testing::Test {
 protected:
  NetworkSegmenterTest() {
    config_.mode = SegmentationMode::kOnnx;
    config_.min_area_px = 1;
    network_.masks.left = {&mask_, 1};
    network_.masks.right = {&mask_, 1};
  }
  void make(int latency_frames) {
    config_.onnx.latency_frames = latency_frames;
    arena_ = std::make_unique<Arena>(required_bytes(config_, kGeometry, 10));
    segmenter_ = make_segmenter(config_, kGeometry, 10, *arena_, {.external = nullptr, .network = &network_}).value();
  }
  /// Four features in the mask move a pixel to the right with every frame.
  DetectionFrame run(std::int64_t index, bool is_cut = false) {
    for (std::uint16_t i = 0; i < features_.size(); ++i) {
      features_[i].id = i + 1U;
      features_[i].slot = i;
      features_[i].left_px = {static_cast<float>(12 + 2 * i + index), 12.F};
      features_[i].u_right_px = features_[i].left_px.x() - disparity_px_;
    }
    SegmentationInput input;
    input.pair.frame_index = index;
    input.features = features_;
    input.is_cut = is_cut;
    segmenter_->load(input.pair, tracks_);
    return segmenter_->process(input).value();
  }

  SegmentationConfig config_;
  ScriptedNetwork network_;
  std::vector<std::uint16_t> runs_{0, 100};
  RunLengthMask mask_{kVehicleClass, 0.9F, {10, 10, 20, 20}, runs_};
  std::vector<Feature> features_{4};
  float disparity_px_ = 0.F;
  std::vector<Track> tracks_;
  std::unique_ptr<Arena> arena_;
  std::unique_ptr<Segmenter> segmenter_;
};

TEST_F(NetworkSegmenterTest, WithoutLatencyEveryFrameHasItsMasks) {
  make(0);
  for (int i = 0; i < 3; ++i) {
    const DetectionFrame frame = run(i);
    ASSERT_TRUE(frame.available);
    ASSERT_EQ(frame.left.size(), 1U);
    EXPECT_EQ(frame.left[0].box_px.x0, 10) << "of this very frame: nothing to move";
  }
  EXPECT_EQ(network_.offered, (std::vector<std::int64_t>{0, 1, 2}));
  EXPECT_EQ(segmenter_->counters().frames_missing, 0U);
}

TEST_F(NetworkSegmenterTest, MasksComeLaterAndWhereTheirObjectIsThen) {
  make(2);
  std::vector<bool> available;
  for (int i = 0; i < 6; ++i) {
    const DetectionFrame frame = run(i);
    available.push_back(frame.available);
    if (frame.available) {
      EXPECT_EQ(frame.left[0].box_px.x0, 12) << "two frames on";
    }
  }
  EXPECT_EQ(available, (std::vector<bool>{false, false, true, false, true, false}));
  EXPECT_EQ(network_.offered, (std::vector<std::int64_t>{0, 2, 4}));
  EXPECT_EQ(segmenter_->counters().frames_missing, 0U) << "none was to come in between";
}

TEST_F(NetworkSegmenterTest, APersonLargerThanAnyIsNone) {
  mask_.class_id = kPedestrianClass;
  for (const int latency_frames : {0, 1}) {
    make(latency_frames);
    disparity_px_ = 1.F;  // a diagonal of 7 m
    const DetectionFrame first = run(0);
    disparity_px_ = 10.F;
    const DetectionFrame second = run(1);
    EXPECT_EQ((latency_frames == 0 ? first : second).left.size(), 0U) << "by the features of its own frame";
    EXPECT_EQ((latency_frames == 0 ? second : run(2)).left.size(), 1U);
  }
}

TEST_F(NetworkSegmenterTest, ASlowNetworkIsTakenWhenItIsDone) {
  make(1);
  network_.is_done = false;
  EXPECT_FALSE(run(0).available);
  EXPECT_FALSE(run(1).available);
  EXPECT_FALSE(run(2).available);
  EXPECT_EQ(segmenter_->counters().frames_missing, 2U);
  network_.is_done = true;
  const DetectionFrame frame = run(3);
  ASSERT_TRUE(frame.available);
  EXPECT_EQ(frame.left[0].box_px.x0, 13) << "three frames on";
  EXPECT_EQ(network_.offered, (std::vector<std::int64_t>{0, 3}));
}

TEST_F(NetworkSegmenterTest, AFailureCostsItsMasksAndNoMore) {
  make(1);
  network_.fails = true;
  EXPECT_FALSE(run(0).available);
  EXPECT_FALSE(run(1).available);
  EXPECT_EQ(segmenter_->counters().frames_missing, 1U);
  network_.fails = false;
  EXPECT_TRUE(run(2).available);
}

TEST_F(NetworkSegmenterTest, TheRightImageIsLookedAtIfAskedFor) {
  config_.onnx.right = true;
  make(1);
  static_cast<void>(run(0));
  const DetectionFrame frame = run(1);
  ASSERT_EQ(frame.right.size(), 1U);
  EXPECT_EQ(frame.right[0].box_px.x0, 11);
}

TEST_F(NetworkSegmenterTest, BetweenWholeImagesItLooksAtRegionsAroundTracks) {
  config_.onnx.regions = 2;
  config_.onnx.right = true;
  tracks_ = {Track{.id = 7, .slot = 0, .box_px = {30, 30, 34, 34}}};
  make(1);
  std::vector<bool> was_region;
  for (int i = 0; i < 8; ++i) {
    const DetectionFrame frame = run(i);
    if (i > 0) {
      was_region.push_back(!frame.searched_px.empty());
      EXPECT_EQ(frame.right_labels.empty(), was_region.back()) << "regions are of the left image";
      EXPECT_TRUE(frame.has_looked_for({30, 30, 34, 34}, kVehicleClass));
      EXPECT_EQ(frame.has_looked_for({0, 0, 64, 48}, kVehicleClass), !was_region.back());
    }
  }
  EXPECT_EQ(was_region, (std::vector<bool>{false, true, true, false, true, true, false}));
  EXPECT_EQ(network_.regions_px[1].width(), 32);
  EXPECT_EQ(network_.regions_px[1].height(), 24);
}

TEST_F(NetworkSegmenterTest, WithoutTracksThereAreNoRegions) {
  config_.onnx.regions = 2;
  make(0);
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(run(i).searched_px.empty());
  }
}

TEST_F(NetworkSegmenterTest, AfterAResetWhatWasUnderWayIsNotUsed) {
  make(1);
  static_cast<void>(run(0));
  segmenter_->reset();
  EXPECT_FALSE(run(1).available);
  EXPECT_EQ(network_.offered, (std::vector<std::int64_t>{0, 1}));
  EXPECT_TRUE(run(2).available);
}

TEST_F(NetworkSegmenterTest, AcrossAJumpNoMasksAreCarried) {
  make(2);
  EXPECT_FALSE(run(0).available);
  EXPECT_FALSE(run(1).available);
  EXPECT_FALSE(run(2, true).available) << "of frame 0";
  EXPECT_EQ(network_.offered, (std::vector<std::int64_t>{0, 2}));
  EXPECT_FALSE(run(3).available);
  EXPECT_TRUE(run(4).available) << "of frame 2";
  network_.is_done = false;
  EXPECT_FALSE(run(5).available);
  EXPECT_FALSE(run(6).available);
  EXPECT_FALSE(run(7, true).available);
  network_.is_done = true;
  EXPECT_FALSE(run(8).available) << "of frame 4";
}

TEST_F(NetworkSegmenterTest, AJumpLeavesMasksOfItsOwnFrame) {
  make(0);
  EXPECT_TRUE(run(0).available);
  EXPECT_TRUE(run(1, true).available);
}

TEST_F(NetworkSegmenterTest, FramesThatWereNotLoadedAreRefused) {
  make(1);
  EXPECT_EQ(segmenter_->process({}).error().code, ErrorCode::kIllegalState);
}

TEST_F(NetworkSegmenterTest, WithoutANetworkOrMemoryThereIsNone) {
  Arena enough(required_bytes(config_, kGeometry, 10));
  EXPECT_EQ(make_segmenter(config_, kGeometry, 10, enough).error().code, ErrorCode::kInvalidConfig);
  Arena small(required_bytes(config_, kGeometry, 10) - 1);
  EXPECT_EQ(make_segmenter(config_, kGeometry, 10, small, {.external = nullptr, .network = &network_}).error().code,
            ErrorCode::kCapacity);
}

}  // namespace
}  // namespace kinetrace::segmentation

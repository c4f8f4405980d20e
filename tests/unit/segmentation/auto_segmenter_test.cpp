#include "kinetrace/segmentation/auto_segmenter.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "synthetic_world.hpp"
#include "thread_per_round_workers.hpp"

namespace kinetrace::segmentation {
namespace {

/// Detects boxes on a test's command.
class BoxNetwork final : public DelayedMaskSource {
 public:
  void offer(const RectifiedPair& /*pair*/, const PixelBox& /*region_px*/) noexcept override {}
  [[nodiscard]] DelayedMasks take() noexcept override { return {is_done, is_done && !fails ? &set_ : nullptr}; }

  void show(std::uint16_t class_id, float score, const PixelBox& box) {
    runs_.push_back({0, static_cast<std::uint16_t>(box.width() * box.height())});
    masks_.push_back({class_id, score, box, {}});
    for (std::size_t i = 0; i < masks_.size(); ++i) {
      masks_[i].runs = runs_[i];
    }
    set_ = {masks_, masks_};
  }

  bool is_done = true;
  bool fails = false;

 private:
  std::vector<std::array<std::uint16_t, 2>> runs_;
  std::vector<RunLengthMask> masks_;
  MaskSet set_;
};

/// One box crosses a street, 20 m ahead of a camera that drives on.
class AutoSegmenterTest : public ::testing::Test {
 protected:
  AutoSegmenterTest() { config_.mode = SegmentationMode::kAuto; }
  void make(DelayedMaskSource* network, Workers* workers = nullptr) {
    const MaskMakers makers{.external = nullptr, .network = network};
    arena_ = std::make_unique<Arena>(required_bytes(config_, world_config_.geometry, world_config_.capacity));
    segmenter_ =
        make_segmenter(config_, world_config_.geometry, world_config_.capacity, *arena_, makers, workers).value();
  }
  DetectionFrame step(bool ego_valid = true) {
    const FeatureFrame frame =
        world_.observe(test::driven(0.5 * frames_), std::array{test::turned(0.0, {-2.0 + 0.6 * frames_, 0.6, 20.0})});
    SegmentationInput input;
    input.features = frame.features;
    input.pair.frame_index = frames_;
    input.pair.timestamp_ns = frame.timestamp_ns;
    input.ego_valid = ego_valid && frames_ > 0;
    input.T_prev_cam = test::driven(0.5);
    ++frames_;
    segmenter_->load(input.pair, {});
    return segmenter_->process(input).value();
  }
  /// Steps until motion is found; returns the last frame.
  DetectionFrame step_until_it_moves() {
    for (int i = 0; i < 9; ++i) {
      step();
    }
    return step();
  }
  [[nodiscard]] static std::size_t count(const DetectionFrame& frame, std::uint16_t class_id) {
    return static_cast<std::size_t>(std::count_if(frame.left.begin(), frame.left.end(),
                                                  [&](const Detection& d) { return d.class_id == class_id; }));
  }

  test::WorldConfig world_config_;
  test::SyntheticWorld world_{world_config_, {{{4.0, 1.5, 1.8}, 60}}};
  SegmentationConfig config_;
  BoxNetwork network_;
  std::unique_ptr<Arena> arena_;
  std::unique_ptr<Segmenter> segmenter_;
  int frames_ = 0;
};

constexpr PixelBox kElsewhere{20, 20, 60, 60};
constexpr float kSure = 0.95F;

TEST_F(AutoSegmenterTest, BothFindWhatTheOtherDoesNotSee) {
  network_.show(kVehicleClass, kSure, kElsewhere);
  make(&network_);
  const DetectionFrame frame = step_until_it_moves();
  ASSERT_TRUE(frame.available);
  EXPECT_FALSE(frame.moving_only);
  EXPECT_EQ(count(frame, kVehicleClass), 1U) << "it stands";
  EXPECT_EQ(count(frame, kUnknownClass), 1U) << "it moves";
  EXPECT_EQ(segmenter_->counters().frames, 10U);
  EXPECT_EQ(segmenter_->counters().frames_missing, 0U);
  EXPECT_GT(segmenter_->counters().detections, 10U);
}

TEST_F(AutoSegmenterTest, WorkersShareTheWorkAndChangeNothing) {
  test::ThreadPerRoundWorkers workers(2);
  network_.show(kVehicleClass, kSure, kElsewhere);
  make(&network_, &workers);
  const DetectionFrame frame = step_until_it_moves();
  EXPECT_EQ(workers.rounds, 10);
  ASSERT_EQ(frame.left.size(), 2U);
  const std::vector<Detection> shared(frame.left.begin(), frame.left.end());
  frames_ = 0;
  world_ = test::SyntheticWorld{world_config_, {{{4.0, 1.5, 1.8}, 60}}};
  make(&network_);
  const DetectionFrame alone = step_until_it_moves();
  ASSERT_EQ(alone.left.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(alone.left[i].box_px.x0, shared[i].box_px.x0);
    EXPECT_EQ(alone.left[i].box_px.y1, shared[i].box_px.y1);
    EXPECT_EQ(alone.left[i].area_px, shared[i].area_px);
  }
}

TEST_F(AutoSegmenterTest, WhatBothSeeIsOneObjectOfTheNetworksClass) {
  make(&network_);
  const DetectionFrame moving = step_until_it_moves();
  ASSERT_EQ(moving.left.size(), 1U);
  ASSERT_EQ(moving.left[0].class_id, kUnknownClass);
  network_.show(kVehicleClass, kSure, moving.left[0].box_px);
  const DetectionFrame both = step();
  ASSERT_EQ(both.left.size(), 1U) << "a mask, and a region on it";
  EXPECT_EQ(both.left[0].class_id, kVehicleClass);
}

TEST_F(AutoSegmenterTest, AFrameWithoutMasksHasWhatMovesAndSaysSo) {
  network_.show(kVehicleClass, kSure, kElsewhere);
  make(&network_);
  for (const bool fails : {false, true}) {
    network_.is_done = fails;
    network_.fails = fails;
    const std::uint64_t missing = segmenter_->counters().frames_missing;
    const DetectionFrame frame = step_until_it_moves();
    ASSERT_TRUE(frame.available);
    EXPECT_TRUE(frame.moving_only);
    EXPECT_EQ(count(frame, kUnknownClass), 1U);
    EXPECT_EQ(frame.left.size(), 1U);
    EXPECT_FALSE(frame.has_looked_for(kElsewhere, kVehicleClass)) << "it may stand there";
    EXPECT_TRUE(frame.has_looked_for(kElsewhere, kUnknownClass));
    EXPECT_GE(segmenter_->counters().frames_missing, missing + 9) << "health says so";
  }
  network_.fails = false;
  EXPECT_EQ(count(step(), kVehicleClass), 1U);
}

TEST_F(AutoSegmenterTest, AFrameWithoutEgoMotionHasWhatTheNetworkSees) {
  network_.show(kVehicleClass, kSure, kElsewhere);
  make(&network_);
  step_until_it_moves();
  const DetectionFrame frame = step(false);
  ASSERT_TRUE(frame.available);
  EXPECT_FALSE(frame.moving_only);
  EXPECT_EQ(frame.left.size(), 1U);
  EXPECT_EQ(count(frame, kVehicleClass), 1U);
  network_.is_done = false;
  EXPECT_FALSE(step(false).available) << "neither has anything to say";
}

TEST_F(AutoSegmenterTest, AResetForgetsWhatMovesAndWhatWasUnderWay) {
  network_.show(kVehicleClass, kSure, kElsewhere);
  make(&network_);
  step_until_it_moves();
  segmenter_->reset();
  EXPECT_TRUE(step().left.empty());
}

TEST_F(AutoSegmenterTest, RightMasksAreTheNetworks) {
  network_.show(kVehicleClass, kSure, kElsewhere);
  network_.show(kVehicleClass, 0.2F, {80, 20, 120, 60});
  make(&network_);
  EXPECT_TRUE(step_until_it_moves().right_labels.empty()) << "nobody has looked";
  config_.onnx.right = true;
  make(&network_);
  step();
  const DetectionFrame frame = step();
  ASSERT_EQ(frame.right.size(), 1U);
  EXPECT_EQ(frame.right_labels.at(100, 40), kBackgroundLabel) << "the weak one is none";
}

TEST_F(AutoSegmenterTest, WithoutANetworkItIsMotion) {
  make(nullptr);
  const DetectionFrame frame = step_until_it_moves();
  EXPECT_EQ(count(frame, kUnknownClass), 1U);
  EXPECT_FALSE(frame.moving_only) << "nothing else is ever looked for";
}

TEST_F(AutoSegmenterTest, FramesThatWereNotLoadedAreRefused) {
  make(&network_);
  EXPECT_EQ(segmenter_->process({}).error().code, ErrorCode::kIllegalState);
}

TEST_F(AutoSegmenterTest, WithoutMemoryThereIsNone) {
  for (const bool right : {false, true}) {
    config_.onnx.right = right;
    Arena small(required_bytes(config_, world_config_.geometry, world_config_.capacity) - 1);
    EXPECT_EQ(
        AutoSegmenter::create(config_, world_config_.geometry, world_config_.capacity, small, &network_).error().code,
        ErrorCode::kCapacity);
  }
  Arena enough(required_bytes(config_, world_config_.geometry, world_config_.capacity));
  EXPECT_EQ(
      AutoSegmenter::create(config_, world_config_.geometry, world_config_.capacity, enough, nullptr).error().code,
      ErrorCode::kInvalidConfig);
}

}  // namespace
}  // namespace kinetrace::segmentation

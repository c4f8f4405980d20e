// Masks of moving regions on pictures of a board before a wall, by way of the whole segmenter.
#include <algorithm>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/segmentation/segmenter.hpp"
#include "kinetrace/segmentation/temporal_test.hpp"
#include "moving_picture.hpp"
#include "synthetic_world.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr std::int64_t kInterval_ns = 100'000'000;
constexpr double kWall_px = 6.3;

StereoGeometry small_rig() {
  StereoGeometry g = test::street_rig();
  g.width_px = 400;
  g.height_px = 200;
  g.cx_px = 199.5;
  g.cy_px = 99.5;
  return g;
}

/// Position of a feature in the left image.
struct Corner {
  double x = 0.0;  ///< Relative to the board's corner if `on_board`, else to the image's.
  double y = 0.0;
  bool on_board = false;
};

/// The camera stands still; the board moves by `step_px` to the right in every frame.
class MovingBoard : public ::testing::Test {
 protected:
  MovingBoard() {
    SegmentationConfig config;
    config.mode = SegmentationMode::kMotion;
    arena_ = std::make_unique<Arena>(required_bytes(config, geometry_, kFeatures));
    segmenter_ = std::move(*make_segmenter(config, geometry_, kFeatures, *arena_));
    for (int y = 12; y < 190; y += 22) {
      for (int x = 12; x < 390; x += 22) {
        corners_.push_back({static_cast<double>(x), static_cast<double>(y), false});
      }
    }
    // The features of the board are all on its left third.
    for (const double y : {15.0, 35.0, 55.0, 75.0}) {
      corners_.push_back({8.0, y, true});
      corners_.push_back({24.0, y, true});
    }
  }

  void step(double step_px) {
    board_.x0 += frame_ == 0 ? 0.0 : step_px;
    picture_.draw(board_);
    std::vector<Feature> now;
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const Corner& c = corners_[i];
      const double u = c.on_board ? board_.x0 + c.x : c.x;
      const double v = c.on_board ? board_.y0 + c.y : c.y;
      const bool hidden = !c.on_board && u > board_.x0 - 8.0 && u < board_.x0 + board_.width + 8.0 &&
                          v > board_.y0 - 8.0 && v < board_.y0 + board_.height + 8.0;
      if (hidden) {
        continue;
      }
      Feature f;
      f.id = static_cast<std::uint32_t>(i + 1);
      f.slot = static_cast<std::uint16_t>(i);
      f.age_frames = static_cast<std::uint32_t>(frame_);
      f.left_px = {static_cast<float>(u), static_cast<float>(v)};
      f.previous_left_px = {static_cast<float>(u - (c.on_board ? step_px : 0.0)), static_cast<float>(v)};
      f.v_px = static_cast<float>(v);
      f.u_right_px = static_cast<float>(u - (c.on_board ? board_.disparity_px : kWall_px));
      now.push_back(f);
    }
    SegmentationInput input;
    input.pair = picture_.pair(frame_, frame_ * kInterval_ns);
    input.features = now;
    input.ego_valid = frame_ > 0;
    last_ = *segmenter_->process(input);
    ++frame_;
  }

  /// Scores the mask of the board.
  [[nodiscard]] double overlap() const {
    int both = 0;
    int either = 0;
    for (int y = 0; y < geometry_.height_px; ++y) {
      for (int x = 0; x < geometry_.width_px; ++x) {
        const bool board =
            x >= board_.x0 && x < board_.x0 + board_.width && y >= board_.y0 && y < board_.y0 + board_.height;
        const bool mask = last_.left_labels.at(x, y) != kBackgroundLabel;
        both += board && mask ? 1 : 0;
        either += board || mask ? 1 : 0;
      }
    }
    return static_cast<double>(both) / either;
  }

  static constexpr int kFeatures = 400;
  StereoGeometry geometry_ = small_rig();
  test::MovingPicture picture_{geometry_, kWall_px};
  test::Board board_{60.0, 50.0, 110.0, 90.0, 17.6};
  std::vector<Corner> corners_;
  std::unique_ptr<Arena> arena_;
  std::unique_ptr<Segmenter> segmenter_;
  DetectionFrame last_;
  std::int64_t frame_ = 0;
};

TEST_F(MovingBoard, IsCoveredToItsContourFromAFewFeaturesOnOneSide) {
  for (int i = 0; i < 12; ++i) {
    step(3.0);
    if (i >= 5) {
      ASSERT_EQ(last_.left.size(), 1U) << i;
      EXPECT_GT(overlap(), 0.8) << i;
    }
  }
}

TEST_F(MovingBoard, HasItsPlainMiddleIfItIsAVehicle) {
  board_ = {60.0, 50.0, 180.0, 90.0, 17.6, 35.0, 145.0};
  for (const double y : {15.0, 35.0, 55.0, 75.0}) {
    corners_.push_back({160.0, y, true});
    corners_.push_back({172.0, y, true});
  }
  for (int i = 0; i < 12; ++i) {
    step(3.0);
  }
  ASSERT_EQ(last_.left.size(), 1U);
  EXPECT_GT(overlap(), 0.85);
}

TEST_F(MovingBoard, StandingStillIsNothing) {
  for (int i = 0; i < 12; ++i) {
    step(0.0);
    EXPECT_TRUE(last_.left.empty()) << i;
  }
}

TEST_F(MovingBoard, ContinuesWithoutItsFeatures) {
  for (int i = 0; i < 8; ++i) {
    step(3.0);
  }
  ASSERT_EQ(last_.left.size(), 1U);
  std::erase_if(corners_, [](const Corner& c) { return c.on_board; });
  for (int i = 0; i < 6; ++i) {
    step(3.0);
    ASSERT_EQ(last_.left.size(), 1U) << i;
    EXPECT_GT(overlap(), 0.7) << i;
  }
}

TEST(TemporalTest, SaysNothingBeforeTheFirstImage) {
  const StereoGeometry geometry = small_rig();
  Arena arena(1U << 20U);
  const FrameHistory history(geometry.width_px, geometry.height_px, arena);
  const TemporalTest test(geometry, history);
  const Eigen::Vector3f velocity(1.F, 0.F, 0.F);
  const int lag = test.discriminating_lag(velocity, 100.F, 90.F, 17.6F);
  EXPECT_EQ(lag, 0);
  EXPECT_EQ(test.lag_after(0.1F), 0);
  EXPECT_EQ(test.cell_nats(test.hypotheses(velocity, lag), 25, 22, 17.6F), 0.F);
}

TEST(TemporalTest, PlacesChangeWithTheVelocityAsTheirDerivativeSays) {
  const StereoGeometry geometry = small_rig();
  test::MovingPicture picture(geometry, kWall_px);
  Arena arena(1U << 20U);
  FrameHistory history(geometry.width_px, geometry.height_px, arena);
  history.push(picture.pair(0, 0).left, {}, 0);
  history.push(picture.pair(1, kInterval_ns).left, test::turned(0.05, {0.1, 0.0, 0.4}), kInterval_ns);
  const TemporalTest test(geometry, history);
  const Eigen::Vector3f velocity(0.5F, -0.2F, 3.F);
  const PastPlaces places = test.places(velocity, 1);
  const Eigen::Vector2f place = places.at(90.F, 70.F, 17.6F);
  const Eigen::Matrix<float, 2, 3> jacobian = places.jacobian(90.F, 70.F, 17.6F, place);
  constexpr float kStep_mps = 0.1F;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3f step = kStep_mps * Eigen::Vector3f::Unit(axis);
    const Eigen::Vector2f difference = (test.places(velocity + step, 1).at(90.F, 70.F, 17.6F) -
                                        test.places(velocity - step, 1).at(90.F, 70.F, 17.6F)) /
                                       (2.F * kStep_mps);
    EXPECT_NEAR((jacobian.col(axis) - difference).norm(), 0.F, 0.01F) << axis;
    EXPECT_GT(difference.norm(), 0.01F) << axis;
  }
}

TEST(TemporalTest, TellsWhatMovesFromWhatStands) {
  const StereoGeometry geometry = small_rig();
  test::MovingPicture picture(geometry, kWall_px);
  Arena arena(1U << 20U);
  FrameHistory history(geometry.width_px, geometry.height_px, arena);
  for (int i = 0; i < 3; ++i) {
    picture.draw({60.0 + 4.0 * i, 50.0, 110.0, 90.0, 17.6});
    history.push(picture.pair(i, i * kInterval_ns).left, {}, i * kInterval_ns);
  }
  const TemporalTest test(geometry, history);
  const double z_m = geometry.depth_m(17.6);
  const Eigen::Vector3f velocity(static_cast<float>(40.0 * z_m / geometry.fx_px), 0.F, 0.F);
  EXPECT_EQ(test.discriminating_lag(velocity, 100.F, 90.F, 17.6F), 1);
  EXPECT_NEAR(test.places_at_rest(2).at(100.F, 90.F, 17.6F).x(), 100.F, 1e-3F);
  EXPECT_NEAR(test.places(velocity, 2).at(100.F, 90.F, 17.6F).x(), 92.F, 1e-3F);
  const TemporalTest::Hypotheses now = test.hypotheses(velocity, 1);
  EXPECT_GT(test.cell_nats(now, 25, 22, 17.6F), 2.F) << "on the board";
  EXPECT_LT(test.cell_nats(now, 70, 22, 17.6F), -2.F) << "on the wall";
  EXPECT_LT(test.cell_nats(test.hypotheses(-velocity, 1), 25, 22, 17.6F), 1.F) << "the other way";
  EXPECT_EQ(test.cell_nats(test.hypotheses(velocity, 3), 25, 22, 17.6F), 0.F) << "before the first image";
}

}  // namespace
}  // namespace kinetrace::segmentation

#include "kinetrace/sfm/pose_history.hpp"

#include <array>

#include <gtest/gtest.h>

#include "synthetic_world.hpp"

namespace kinetrace::sfm {
namespace {

using kinetrace::test::driven;

FinalisedPose frame(std::int64_t index, const Se3& T_body_cam = {}) {
  return {.frame_index = index, .status = BodyStatus::kTracked, .T_body_cam = T_body_cam};
}

double z(const FinalisedPose& pose) {
  return pose.T_body_cam.translation.z();
}

class PoseHistoryTest : public ::testing::Test {
 protected:
  Arena arena_{1 << 16};
  PoseHistory history_{arena_, 3};
  std::array<Se3, 3> poses_{driven(10.0), driven(11.0), driven(12.0)};
};

TEST_F(PoseHistoryTest, FollowsTheWindowColumnItHangsOn) {
  history_.push(frame(0), 0);
  history_.push(frame(1), 2);
  EXPECT_EQ(z(history_.at(1, poses_)), 10.0);
  EXPECT_EQ(z(history_.at(0, poses_)), 12.0);
  poses_[2] = driven(12.5);  // Refined.
  EXPECT_EQ(z(history_.at(0, poses_)), 12.5);
}

TEST_F(PoseHistoryTest, AFrozenPoseStays) {
  history_.push(frame(0, driven(5.0)), PoseHistory::kFrozen);
  poses_[0] = driven(99.0);
  EXPECT_EQ(z(history_.at(0, poses_)), 5.0);
}

TEST_F(PoseHistoryTest, ADroppedColumnFreezesItsFrameAndShiftsTheLaterOnes) {
  history_.push(frame(0), 0);
  history_.push(frame(1), 1);
  history_.drop_column(0, poses_, PoseHistory::kFrozen);
  poses_ = {driven(11.5), driven(12.5), driven(13.0)};
  EXPECT_EQ(z(history_.at(1, poses_)), 10.0);
  EXPECT_EQ(z(history_.at(0, poses_)), 11.5);
}

TEST_F(PoseHistoryTest, ARedundantFrameFollowsItsTargetAtTheOldDistance) {
  history_.push(frame(0), 1);
  history_.push(frame(1), 2);
  history_.drop_column(2, poses_, 1);
  poses_[1] = driven(20.0);
  EXPECT_NEAR(z(history_.at(0, poses_)), 21.0, 1e-12);
  EXPECT_EQ(z(history_.at(1, poses_)), 20.0);
  // The target column moves down with its column, then freezes with it.
  history_.drop_column(0, poses_, PoseHistory::kFrozen);
  poses_[0] = driven(30.0);
  EXPECT_NEAR(z(history_.at(0, poses_)), 31.0, 1e-12);
  history_.drop_column(0, poses_, PoseHistory::kFrozen);
  poses_[0] = driven(99.0);
  EXPECT_NEAR(z(history_.at(0, poses_)), 31.0, 1e-12);
  EXPECT_EQ(z(history_.at(1, poses_)), 30.0);
}

TEST_F(PoseHistoryTest, HoldsItsCapacityAndForgetsTheOldest) {
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(history_.size(), static_cast<std::size_t>(i));
    history_.push(frame(i, driven(i)), PoseHistory::kFrozen);
  }
  EXPECT_EQ(history_.at(2, poses_).frame_index, 0);
  history_.push(frame(3, driven(3.0)), PoseHistory::kFrozen);
  EXPECT_EQ(history_.size(), 3U);
  for (std::size_t age = 0; age < 3; ++age) {
    EXPECT_EQ(history_.at(age, poses_).frame_index, 3 - static_cast<std::int64_t>(age));
  }
}

TEST_F(PoseHistoryTest, FreezeKeepsEveryPoseAsItIs) {
  history_.push(frame(0), 0);
  history_.push(frame(1), 2);
  history_.freeze(poses_);
  poses_.fill(driven(99.0));
  EXPECT_EQ(z(history_.at(1, poses_)), 10.0);
  EXPECT_EQ(z(history_.at(0, poses_)), 12.0);
}

TEST_F(PoseHistoryTest, OnlyTheNewestFramesFiguresChange) {
  history_.push(frame(0), 0);
  history_.push(frame(1), 1);
  history_.update_newest(BodyStatus::kPropagated, Matrix6d::Identity(), 7);
  EXPECT_EQ(history_.at(0, poses_).status, BodyStatus::kPropagated);
  EXPECT_EQ(history_.at(0, poses_).inliers, 7);
  EXPECT_EQ(history_.at(0, poses_).covariance, Matrix6d::Identity());
  EXPECT_EQ(history_.at(1, poses_).status, BodyStatus::kTracked);
  EXPECT_EQ(history_.at(1, poses_).inliers, 0);
}

TEST_F(PoseHistoryTest, ClearForgetsEverything) {
  history_.push(frame(0), 0);
  history_.clear();
  EXPECT_EQ(history_.size(), 0U);
}

}  // namespace
}  // namespace kinetrace::sfm

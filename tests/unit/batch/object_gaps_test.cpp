// Gaps in an object's path: filled where its two ends agree.
#include "object_gaps.hpp"

#include <gtest/gtest.h>

namespace kinetrace::batch {
namespace {

constexpr std::size_t kFrames = 30;
constexpr std::size_t kGapBegin = 10;
constexpr std::size_t kGapEnd = 20;
constexpr double kSpeed_mps = 10.0;

class ObjectGaps : public ::testing::Test {
 protected:
  ObjectGaps() {
    for (std::size_t k = 0; k < kFrames; ++k) {
      run_.camera.push_back({static_cast<std::int64_t>(k), static_cast<std::int64_t>(k) * 100'000'000, {}});
    }
  }
  /// Drives along x; from the end of the gap on, `aside_m` to the side.
  void drive(double aside_m) {
    for (std::size_t k = 0; k < kFrames; ++k) {
      recording::ObjectRow row;
      row.frame = static_cast<std::int64_t>(k);
      row.timestamp_ns = run_.camera[k].timestamp_ns;
      row.status = k < kGapBegin || k >= kGapEnd ? BodyStatus::kTracked : BodyStatus::kLost;
      row.T_world_obj.translation = {0.1 * kSpeed_mps * static_cast<double>(k), 0.0,
                                     20.0 + (k < kGapEnd ? 0.0 : aside_m)};
      row.velocity_mps = {kSpeed_mps, 0.0, 0.0};
      row.box.center_m = row.T_world_obj.translation + Eigen::Vector3d(0.5, 0.0, 0.0);
      if (row.status == BodyStatus::kLost) {
        row.T_world_obj.translation.setZero();
      }
      object_.frames[k] = {row, row.T_world_obj.inverse()};
    }
    fill_gaps(run_, T_world_cam_, object_);
  }

  recording::Run run_;
  std::vector<Se3> T_world_cam_ = std::vector<Se3>(kFrames);
  RefinedObject object_;
};

TEST_F(ObjectGaps, AreFilledWhereTheMotionContinues) {
  drive(0.0);
  for (std::size_t k = kGapBegin; k < kGapEnd; ++k) {
    const recording::ObjectRow& row = object_.frames.at(k).row;
    EXPECT_EQ(row.status, BodyStatus::kPropagated);
    EXPECT_NEAR(row.T_world_obj.translation.x(), 0.1 * kSpeed_mps * static_cast<double>(k), 1e-9);
    EXPECT_NEAR(row.box.center_m.x(), 0.1 * kSpeed_mps * static_cast<double>(k) + 0.5, 1e-9);
    EXPECT_NEAR(row.velocity_mps.x(), kSpeed_mps, 1e-9);
    EXPECT_EQ(row.frame, static_cast<std::int64_t>(k));
  }
}

TEST_F(ObjectGaps, AreFilledByThePathOfOnePointWhereTheBoxesAtTheEndsDiffer) {
  drive(0.0);
  for (std::size_t k = kGapBegin; k < kFrames; ++k) {
    recording::ObjectRow& row = object_.frames.at(k).row;
    row.status = k < kGapEnd ? BodyStatus::kLost : row.status;
    row.box.center_m.x() += 0.4;
  }
  fill_gaps(run_, T_world_cam_, object_);
  for (std::size_t k = kGapBegin; k < kGapEnd; ++k) {
    const recording::ObjectRow& row = object_.frames.at(k).row;
    EXPECT_EQ(row.status, BodyStatus::kPropagated);
    const double x_m = 0.1 * kSpeed_mps * static_cast<double>(k);
    EXPECT_NEAR(row.T_world_obj.translation.x(), x_m, 1e-9);
    EXPECT_GT(row.box.center_m.x(), x_m + 0.5);
    EXPECT_LT(row.box.center_m.x(), x_m + 0.9);
  }
}

TEST_F(ObjectGaps, StayWhereNothingCanHaveGoneThatWay) {
  drive(15.0);
  for (std::size_t k = kGapBegin; k < kGapEnd; ++k) {
    EXPECT_EQ(object_.frames.at(k).row.status, BodyStatus::kLost);
  }
}

class ObjectBirth : public ObjectGaps {
 protected:
  static constexpr std::size_t kFirst = 8;
  ObjectBirth() {
    run_.rectified = {721.0, 721.0, 610.0, 173.0, 0.54, 1242, 375};
    drive(0.0);
    object_.frames.erase(object_.frames.begin(), object_.frames.find(kFirst));
  }
  /// A mask around the object's position in a row, shifted by `aside_px`.
  [[nodiscard]] PixelBox mask_px(std::size_t row, int aside_px = 0) const {
    const Eigen::Vector3d px = run_.rectified.project({0.1 * kSpeed_mps * static_cast<double>(row) + 0.5, 0.0, 20.0});
    const int u = static_cast<int>(px.x()) + aside_px;
    return {u - 20, 150, u + 20, 200};
  }
};

TEST_F(ObjectBirth, IsCarriedBackToWhereItsMaskWasSeenFirst) {
  fill_birth(run_, T_world_cam_, {{7, mask_px(7)}, {6, mask_px(6)}, {4, mask_px(4)}}, object_);
  EXPECT_EQ(object_.frames.begin()->first, 6U);
  const recording::ObjectRow& row = object_.frames.at(6).row;
  EXPECT_EQ(row.status, BodyStatus::kPropagated);
  EXPECT_NEAR(row.box.center_m.x(), 0.1 * kSpeed_mps * 6.0 + 0.5, 1e-9);
  EXPECT_EQ(row.pixel_height, 50);
}

TEST_F(ObjectBirth, EndsWhereTheMaskIsElsewhere) {
  fill_birth(run_, T_world_cam_, {{7, mask_px(7)}, {6, mask_px(6, 60)}}, object_);
  EXPECT_EQ(object_.frames.begin()->first, 7U);
}

}  // namespace
}  // namespace kinetrace::batch

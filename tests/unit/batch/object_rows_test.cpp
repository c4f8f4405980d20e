// Boxes along a refined path, of online boxes that were seen from the camera.
#include "object_rows.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace kinetrace::batch {
namespace {

constexpr std::size_t kRows = 20;
const Eigen::Vector3d kSize_m{4.2, 1.5, 1.8};
const Eigen::Vector3d kCenter_obj_m{0.3, -0.2, 1.1};

/// A car ahead of a camera that stands still.
class PlacedBoxes : public ::testing::Test {
 protected:
  void SetUp() override {
    run_.camera.resize(kRows);
    for (std::size_t k = 0; k < kRows; ++k) {
      recording::ObjectRow row;
      row.status = BodyStatus::kTracked;
      row.T_world_obj = T_world_obj(k);
      row.box.center_m = T_world_obj(k) * kCenter_obj_m;
      row.box.size_m = kSize_m;
      row.box_sigma.size_m.setConstant(0.1);
      history_.rows[k] = row;
      object_.frames[k] = {row, row.T_world_obj.inverse()};
    }
  }
  static Se3 T_world_obj(std::size_t k) {
    return {Eigen::Matrix3d::Identity(), {0.5 * static_cast<double>(k), 0.0, 12.0}};
  }
  void expect_true_boxes() const {
    for (const auto& [row, frame] : object_.frames) {
      EXPECT_NEAR(std::remainder(frame.row.box.yaw_rad, std::numbers::pi), 0.0, 1e-9) << row;
      EXPECT_LT((frame.row.box.center_m - T_world_obj(row) * kCenter_obj_m).norm(), 1e-9) << row;
      EXPECT_EQ(frame.row.box.size_m, kSize_m) << row;
    }
  }

  recording::Run run_;
  ObjectHistory history_;
  RefinedObject object_;
};

TEST_F(PlacedBoxes, AreNotThoseOfTheFramesBeforeTheTrackWentToAnotherObject) {
  for (std::size_t k = 0; k < 4; ++k) {
    recording::ObjectRow& row = history_.rows.at(k);
    row.box.size_m = {1.0, 1.7, 0.6};
    row.box.center_m.x() -= 3.0;
    row.box_sigma.size_m.setConstant(0.05);
  }
  place_boxes(run_, history_, object_);
  expect_true_boxes();
}

TEST_F(PlacedBoxes, StayWhereTheCameraSawThemWhereTheRunsObjectFrameTurns) {
  for (auto& [k, row] : history_.rows) {
    row.T_world_obj.rotation = so3_exp({0.0, 0.02 * static_cast<double>(k), 0.0});
  }
  place_boxes(run_, history_, object_);
  expect_true_boxes();
}

TEST_F(PlacedBoxes, DoNotDependOnWhichEndIsTheFront) {
  for (std::size_t k = 0; k < kRows; k += 2) {
    history_.rows.at(k).box.yaw_rad = std::numbers::pi;
  }
  place_boxes(run_, history_, object_);
  expect_true_boxes();
}

TEST_F(PlacedBoxes, AreTheirOwnWhereAllFramesAreStereoOnly) {
  for (auto& [k, row] : history_.rows) {
    row.status = BodyStatus::kStereoOnly;
    row.box.size_m.x() = 4.0 + 0.1 * static_cast<double>(k);
  }
  place_boxes(run_, history_, object_);
  for (const auto& [row, frame] : object_.frames) {
    EXPECT_EQ(frame.row.box.size_m, history_.rows.at(row).box.size_m) << row;
  }
}

}  // namespace
}  // namespace kinetrace::batch

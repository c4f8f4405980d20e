// Tracks cut in two: joined only if one continues the other.
#include "object_joining.hpp"

#include <gtest/gtest.h>

namespace kinetrace::batch {
namespace {

constexpr double kFrame_s = 0.1;

/// An object that drives along x at `speed_mps`, at x = `x_m` in row 0, seen in rows [first, last].
struct Drive {
  std::uint32_t track_id = 1;
  std::size_t first = 0;
  std::size_t last = 10;
  double x_m = 0.0;
  double speed_mps = 10.0;
  double z_m = 20.0;
  std::uint16_t class_id = 1;
  double length_m = 4.0;
};

RefinedObject object_of(const Drive& drive, const Se3& T_obj_frame = {}) {
  RefinedObject object;
  for (std::size_t k = drive.first; k <= drive.last; ++k) {
    recording::ObjectRow row;
    row.frame = static_cast<std::int64_t>(k);
    row.timestamp_ns = static_cast<std::int64_t>(k) * 100'000'000;
    row.track_id = drive.track_id;
    row.class_id = drive.class_id;
    row.status = BodyStatus::kTracked;
    row.moving = true;
    row.velocity_mps = {drive.speed_mps, 0.0, 0.0};
    row.box.center_m = {drive.x_m + drive.speed_mps * kFrame_s * static_cast<double>(k), 0.0, drive.z_m};
    row.box.size_m = {drive.length_m, 1.5, 1.8};
    row.box_sigma.size_m = {0.1, 0.05, 0.05};
    row.T_world_obj = Se3{Eigen::Matrix3d::Identity(), row.box.center_m} * T_obj_frame;
    object.frames[k] = {row, row.T_world_obj.inverse()};
  }
  object.points.push_back({.id = drive.track_id, .position_m = T_obj_frame.inverse() * Eigen::Vector3d(1.0, 0.0, 0.0)});
  return object;
}

std::map<std::uint32_t, RefinedObject> objects_of(std::initializer_list<Drive> drives) {
  std::map<std::uint32_t, RefinedObject> objects;
  for (const Drive& drive : drives) {
    objects.emplace(drive.track_id, object_of(drive));
  }
  return objects;
}

TEST(JoinTracks, JoinsTheTrackAtThePredictedPlace) {
  auto objects = objects_of({{.track_id = 1, .last = 10}, {.track_id = 2, .first = 25, .last = 40}});
  const auto joined_into = join_tracks(objects);
  ASSERT_EQ(joined_into, (std::map<std::uint32_t, std::uint32_t>{{2, 1}}));
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_EQ(objects.at(1).frames.rbegin()->first, 40U);
  EXPECT_EQ(objects.at(1).frames.at(40).row.track_id, 1U);
}

TEST(JoinTracks, KeepsTheFrameOfTheEarlierTrack) {
  const Se3 other{so3_exp({0.0, 0.4, 0.0}), {0.5, -0.2, 1.0}};
  std::map<std::uint32_t, RefinedObject> objects;
  objects.emplace(1, object_of({.track_id = 1, .last = 10}));
  objects.emplace(2, object_of({.track_id = 2, .first = 20, .last = 30}, other));
  ASSERT_EQ(join_tracks(objects).size(), 1U);
  const RefinedObject& joined = objects.at(1);
  for (const auto& [row, frame] : joined.frames) {
    EXPECT_LT((frame.row.T_world_obj.translation - frame.row.box.center_m).norm(), 1e-9) << row;
    EXPECT_LT((frame.T_obj_cam * frame.row.T_world_obj).translation.norm(), 1e-9) << row;
  }
  for (const RefinedPoint& point : joined.points) {
    EXPECT_LT((joined.frames.at(30).row.T_world_obj * point.position_m -
               (joined.frames.at(30).row.box.center_m + Eigen::Vector3d(1.0, 0.0, 0.0)))
                  .norm(),
              1.0);
  }
}

TEST(JoinTracks, LeavesApartWhatIsElsewhere) {
  auto objects = objects_of({{.track_id = 1}, {.track_id = 2, .first = 25, .last = 40, .x_m = 8.0}});
  EXPECT_TRUE(join_tracks(objects).empty());
}

TEST(JoinTracks, LeavesApartWhatIsSeenAtOnce) {
  auto objects = objects_of({{.track_id = 1, .last = 26}, {.track_id = 2, .first = 25, .last = 40}});
  EXPECT_TRUE(join_tracks(objects).empty());
}

TEST(JoinTracks, LeavesApartOtherKindsAndSizes) {
  auto kinds = objects_of({{.track_id = 1}, {.track_id = 2, .first = 20, .last = 40, .class_id = 2}});
  EXPECT_TRUE(join_tracks(kinds).empty());
  auto sizes = objects_of({{.track_id = 1}, {.track_id = 2, .first = 20, .last = 40, .length_m = 9.0}});
  EXPECT_TRUE(join_tracks(sizes).empty());
}

TEST(JoinTracks, LeavesApartWhatMayBeEitherOfTwo) {
  auto objects = objects_of({{.track_id = 1},
                             {.track_id = 2, .first = 25, .last = 40, .z_m = 20.3},
                             {.track_id = 3, .first = 25, .last = 40, .z_m = 19.7}});
  EXPECT_TRUE(join_tracks(objects).empty());
}

}  // namespace
}  // namespace kinetrace::batch

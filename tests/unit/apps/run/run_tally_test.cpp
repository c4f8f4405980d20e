#include "run/run_tally.hpp"

#include <gtest/gtest.h>

namespace kinetrace::app {
namespace {

TEST(RunTally, AddsUpTheCamerasPath) {
  RunTally tally;
  EXPECT_EQ(tally.found().camera_path_m, 0.0);
  tally.add_camera({5.0, 0.0, 0.0});
  EXPECT_EQ(tally.found().camera_path_m, 0.0);
  tally.add_camera({5.0, 0.0, 2.0});
  tally.add_camera({5.0, 1.0, 2.0});
  EXPECT_DOUBLE_EQ(tally.found().camera_path_m, 3.0);
  EXPECT_EQ(tally.found().poses, 3U);
}

TEST(RunTally, AnObjectCountsOnceAndAsMovedOnce) {
  RunTally tally;
  tally.add_object(7, BodyStatus::kTracked, false);
  tally.add_object(8, BodyStatus::kStereoOnly, true);
  tally.add_object(7, BodyStatus::kTracked, true);
  tally.add_object(7, BodyStatus::kPropagated, true);
  tally.add_object(8, BodyStatus::kTracked, false);
  EXPECT_EQ(tally.found().objects, 2U);
  EXPECT_EQ(tally.found().objects_moved, 2U);
}

TEST(RunTally, WithoutAPoseAnObjectDoesNotCount) {
  RunTally tally;
  tally.add_object(1, BodyStatus::kInitializing, true);
  tally.add_object(2, BodyStatus::kLost, true);
  EXPECT_EQ(tally.found().objects, 0U);
}

TEST(RunTally, RemembersThoseThatWereSeenLast) {
  RunTally tally;
  for (std::uint32_t id = 1; id <= 512; ++id) {
    tally.add_object(id, BodyStatus::kTracked, true);
  }
  tally.add_object(1, BodyStatus::kTracked, true);
  EXPECT_EQ(tally.found().objects, 512U);
  // One beyond the limit: number 2, unseen for longest, is forgotten.
  tally.add_object(513, BodyStatus::kTracked, true);
  tally.add_object(1, BodyStatus::kTracked, true);
  tally.add_object(3, BodyStatus::kTracked, true);
  EXPECT_EQ(tally.found().objects, 513U);
  EXPECT_EQ(tally.found().objects_moved, 513U);
}

TEST(RunTally, SaysWhatWasFound) {
  const recording::FoundSummary found{.poses = 20, .camera_path_m = 13.214, .objects = 5, .objects_moved = 3};
  EXPECT_EQ(found_text(found, true), "camera: 13.21 m in 20 frames; objects: 5, of which 3 moved");
  EXPECT_EQ(found_text({.poses = 1}, true), "camera: 0.00 m in 1 frames; objects: none");
  EXPECT_EQ(found_text({}, false), "camera: 0.00 m in 0 frames; objects: not looked for, segmentation is none");
}

}  // namespace
}  // namespace kinetrace::app

// Playing and rectifying allocate no memory of our own after start.
#include <gtest/gtest.h>

#include "fake_capture.hpp"
#include "kinetrace/core/allocation_counter.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "kinetrace/hal/frame_guard.hpp"
#include "kinetrace/hal/live_stereo_camera.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/hal/sync_monitor.hpp"
#include "recording_for_test.hpp"

namespace kinetrace::hal {
namespace {

TEST(HalAllocations, AreAllForeign) {
  ASSERT_TRUE(allocation_counting_available());
  const test::Recording recording(4);
  std::filesystem::remove(recording.right(1));
  Dataset dataset = recording.open().value();
  // The same pinhole, shifted, so that rectification is needed.
  RigCalibration rig;
  rig.left = {.width_px = test::kWidth,
              .height_px = test::kHeight,
              .fx_px = 40,
              .fy_px = 40,
              .cx_px = 24,
              .cy_px = 16,
              .distortion = {-0.1}};
  rig.right = rig.left;
  rig.T_right_left.translation = {-0.5, 0, 0};
  const FileCameraConfig config{.passes = 2};
  Arena arena(FileStereoCamera::required_bytes(dataset, config) + Rectifier::required_bytes(rig, {}));
  Rectifier rectifier = Rectifier::create(rig, {}, arena).value();
  ASSERT_FALSE(rectifier.passes_through());
  FileStereoCamera camera = FileStereoCamera::create(std::move(dataset), config, arena).value();
  ASSERT_TRUE(camera.open() && camera.start());

  const AllocationCounts before = allocation_counts();
  int frames = 0;
  for (int i = 0; i < 6; ++i) {
    const auto frame = camera.next(std::chrono::milliseconds(100));
    frames += frame && rectifier.process(*frame) ? 1 : 0;
  }
  const AllocationCounts after = allocation_counts();

  EXPECT_EQ(frames, 6);
  EXPECT_EQ(after.own, before.own);
  EXPECT_GT(after.foreign, before.foreign);
}

TEST(HalAllocations, ALiveCameraNeedsNoneWhateverItDrops) {
  ASSERT_TRUE(allocation_counting_available());
  test::FakeMachine machine;
  test::FakeSensor& left = machine.add({.path = "left", .stable_id = "left"});
  machine.add({.path = "right", .stable_id = "right"});
  left.script = [](test::Shot& shot) {
    shot.lost = shot.number % 7 == 0;
    shot.damaged = shot.number % 11 == 0;
  };
  const LiveCameraConfig config = test::live_config("left", "right");
  Arena arena(LiveStereoCamera::required_bytes(config) + SyncMonitor::required_bytes({}, 640, 480) +
              2 * Arena::kAlignment);
  auto live = LiveStereoCamera::create(config, arena, machine).value();
  SyncMonitor monitor = SyncMonitor::create({}, 640, 480, arena).value();
  FrameGuard camera(std::make_unique<LiveStereoCamera>(std::move(live)), {});
  ASSERT_TRUE(camera.open() && camera.start());

  const AllocationCounts before = allocation_counts();
  int frames = 0;
  for (int i = 0; i < 200; ++i) {
    const auto frame = camera.next(std::chrono::milliseconds(200));
    if (frame) {
      ++frames;
      monitor.process({frame->frame_index, frame->timestamp_ns, {}, frame->left, frame->right, {}});
    }
  }
  const AllocationCounts after = allocation_counts();
  EXPECT_EQ(frames, 200);
  EXPECT_EQ(after.own, before.own);
  EXPECT_GT(camera.counters().skipped_missing_side, 20U);
}

}  // namespace
}  // namespace kinetrace::hal

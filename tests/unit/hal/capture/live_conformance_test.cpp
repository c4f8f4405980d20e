// Live cameras on scripted devices, and all camera wrappers, pass the conformance suite.
#include "camera_conformance.hpp"
#include "fake_capture.hpp"
#include "kinetrace/hal/fault_injector.hpp"
#include "kinetrace/hal/frame_guard.hpp"
#include "kinetrace/hal/live_stereo_camera.hpp"

namespace kinetrace::hal::test {
namespace {

enum class Wrapped { kNot, kGuarded, kFaulty };

class LiveBench final : public CameraBench {
 public:
  LiveBench(bool side_by_side, Wrapped wrapped) : arena_(std::size_t{4} << 20U) {
    machine_.add({.path = "left", .stable_id = "left id", .side_by_side = side_by_side});
    machine_.add({.path = "right", .stable_id = "right id"});
    const LiveCameraConfig config = live_config("left", side_by_side ? "" : "right");
    camera_ = std::make_unique<LiveStereoCamera>(LiveStereoCamera::create(config, arena_, machine_).value());
    if (wrapped == Wrapped::kGuarded) {
      camera_ = std::make_unique<FrameGuard>(std::move(camera_), FrameGuardConfig{});
    } else if (wrapped == Wrapped::kFaulty) {
      camera_ =
          FaultInjector::create(std::move(camera_), parse_faults("drop@1,reorder@2").value(), 640, 480, arena_).value();
      camera_ = std::make_unique<FrameGuard>(std::move(camera_), FrameGuardConfig{});
    }
  }
  StereoCamera& camera() override { return *camera_; }

 private:
  FakeMachine machine_;
  Arena arena_;
  std::unique_ptr<StereoCamera> camera_;
};

std::unique_ptr<CameraBench> two_devices() {
  return std::make_unique<LiveBench>(false, Wrapped::kNot);
}
std::unique_ptr<CameraBench> side_by_side() {
  return std::make_unique<LiveBench>(true, Wrapped::kNot);
}
std::unique_ptr<CameraBench> guarded() {
  return std::make_unique<LiveBench>(false, Wrapped::kGuarded);
}
std::unique_ptr<CameraBench> faulty() {
  return std::make_unique<LiveBench>(false, Wrapped::kFaulty);
}

INSTANTIATE_TEST_SUITE_P(Live, CameraConformance,
                         ::testing::Values(CameraKind{"TwoDevices", &two_devices},
                                           CameraKind{"SideBySide", &side_by_side}, CameraKind{"Guarded", &guarded},
                                           CameraKind{"Faulty", &faulty}),
                         name_of_kind);

}  // namespace
}  // namespace kinetrace::hal::test

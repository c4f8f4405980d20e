// A live stereo camera and the memory it needs.
#pragma once

#include <memory>

#include "camera_conformance.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/hal/live_stereo_camera.hpp"

namespace kinetrace::hal::test {

/// Two devices as one camera, or one side by side if `right` is empty. Time-outs are long, for an emulated machine.
[[nodiscard]] LiveCameraConfig live_config(const CaptureConfig& left, const std::optional<CaptureConfig>& right);

class LiveBench final : public CameraBench {
 public:
  explicit LiveBench(const LiveCameraConfig& config)
      : arena_(LiveStereoCamera::required_bytes(config) + 1),
        camera_(LiveStereoCamera::create(config, arena_).value()) {}
  StereoCamera& camera() override { return camera_; }

 private:
  Arena arena_;
  LiveStereoCamera camera_;
};

}  // namespace kinetrace::hal::test

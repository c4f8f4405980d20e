// Reads frames from a camera until the end, through time-outs and loss.
#pragma once

#include <functional>

#include "camera/health_monitor.hpp"
#include "cli/progress.hpp"
#include "cli/shared_options.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/stage.hpp"
#include "kinetrace/hal/stereo_camera.hpp"

namespace kinetrace::app {

struct CameraLoop {
  hal::StereoCamera& camera;  ///< Started.
  UntilOptions until;
  bool waits_for_camera = false;  ///< Waits until a lost camera returns; else its loss ends the loop.
  HealthMonitor& health;
  Progress& progress;
  StageObserver* observer = nullptr;  ///< Observes Stage::kCapture.
  std::function<void()> on_idle{};    ///< Called repeatedly while no frame arrives; may be empty.
};

/// Calls `visit` with every frame until the recording ends, a limit is reached or a signal arrives. Reading is retried
/// after a time-out. Errors: those of `visit`; kDisconnected without `waits_for_camera`; other errors of the camera;
/// kTimeout if no frame at all arrived.
[[nodiscard]] Status play_camera(const CameraLoop& loop, const std::function<Status(const StereoFrame&)>& visit);

}  // namespace kinetrace::app

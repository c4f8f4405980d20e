// Frame after frame from a camera, through silence and loss, until the end.
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
  bool waits_for_camera = false;  ///< Takes a lost camera back whenever it returns; else its loss is the end.
  HealthMonitor& health;
  Progress& progress;
  StageObserver* observer = nullptr;  ///< Of Stage::kCapture.
  std::function<void()> on_idle{};    ///< Called now and then while no frame comes; may be empty.
};

/// Calls `visit` with every frame until the recording ends, a limit is reached or a signal came. A camera that says
/// nothing is asked again. Errors: those of `visit`; kDisconnected of a camera that is not waited for; whatever else
/// the camera reports; kTimeout if not a single frame came.
[[nodiscard]] Status play_camera(const CameraLoop& loop, const std::function<Status(const StereoFrame&)>& visit);

}  // namespace kinetrace::app

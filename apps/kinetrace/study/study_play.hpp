// Plays a recording through the pipeline without a run folder.
#pragma once

#include <functional>

#include "config/app_config.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "live/stage_clock.hpp"

namespace kinetrace::app {

/// Calls `visit` with every result, those of draining included, until the first error or an interrupt (interrupt.hpp).
/// The memory budget does not apply, but that it may leave no room for a network: segmentation.mode auto is then motion
/// from here on, and that is said. `clock`, if there is one, times every frame. Errors: those of the parts and of
/// `visit`.
[[nodiscard]] Status play_recording(const hal::Dataset& dataset, AppConfig& config,
                                    const std::function<Status(const FrameResult&)>& visit,
                                    StageClock* clock = nullptr);

}  // namespace kinetrace::app

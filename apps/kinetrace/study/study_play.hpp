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
/// The memory budget applies to the network alone: without room for it, segmentation.mode auto becomes motion, with a
/// warning. `clock` may be null; else it times every frame. Errors: those of the parts and of `visit`.
[[nodiscard]] Status play_recording(const hal::Dataset& dataset, AppConfig& config,
                                    const std::function<Status(const FrameResult&)>& visit,
                                    StageClock* clock = nullptr);

}  // namespace kinetrace::app

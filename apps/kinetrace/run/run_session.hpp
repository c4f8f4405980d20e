// One run, from the first frame to the finished run folder.
#pragma once

#include "kinetrace/core/arena.hpp"
#include "run/frame_processor.hpp"
#include "run/run_components.hpp"
#include "run/run_report.hpp"
#include "run/run_setup.hpp"

namespace kinetrace::app {

/// Calls in this order: begin, play, finish. `setup` and `components` must outlive it; without finish(), the
/// destructors end the threads and the run folder stays unfinished.
class RunSession {
 public:
  RunSession(RunSetup& setup, RunComponents& components);

  /// Starts the camera and the run folder; in live mode allocates from the arena. Errors: those of the camera, the
  /// recorder and FrameProcessor::go_live.
  [[nodiscard]] Status begin(Arena& arena);
  /// Processes frames until the recording ends, a limit is reached or a signal arrives. Errors: those of play_camera.
  [[nodiscard]] Status play();
  /// Writes the results in any case; `played`: status of the frames. Returns it, or else the first error of finishing.
  [[nodiscard]] Status finish(Status played);

  [[nodiscard]] RunReport& report() noexcept { return report_; }

 private:
  [[nodiscard]] Status finalize();
  /// If requested and the calibration was found wrong.
  [[nodiscard]] Status save_calibration();
  void report_components();

  RunSetup& setup_;
  RunComponents& components_;
  RunReport report_;
  FrameProcessor processor_;  ///< Last, so that its thread ends first.
};

}  // namespace kinetrace::app

// The components of a run.
#pragma once

#include <memory>
#include <optional>

#include "camera/camera_setup.hpp"
#include "camera/input_watch.hpp"
#include "camera/recording_thread.hpp"
#include "cli/failure.hpp"
#include "dds/run_publishing.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/pipeline/pipeline.hpp"
#include "kinetrace/recording/run_recorder.hpp"
#include "live/service_notifier.hpp"
#include "live/worker_threads.hpp"
#include "run/run_setup.hpp"
#include "segmentation/mask_file_watch.hpp"
#include "segmentation/mask_mailbox.hpp"
#include "segmentation/network_thread.hpp"

namespace kinetrace::app {

/// In the order that a frame passes them. All memory is taken when they are made.
struct RunComponents {
  GuardedCamera camera;
  hal::Rectifier rectifier;
  std::unique_ptr<WorkerThreads> workers;  ///< Share what takes longest in a frame.
  std::unique_ptr<NetworkThread> network;  ///< Null unless a neural network takes part.
  std::unique_ptr<MaskMailbox> masks;      ///< Null unless masks come from another process.
  pipeline::Pipeline pipeline;
  recording::RunRecorder recorder;
  InputWatch input;
  std::optional<MaskFileWatch> mask_files;       ///< Where masks come from files.
  std::unique_ptr<RecordingThread> raw;          ///< Null unless asked for.
  std::unique_ptr<RecordingThread> raw_ended{};  ///< What became of it where it stopped early.
  bool refines_calibration = false;              ///< And corrects it.
  bool waits_for_disk = false;                   ///< Recordings do; a camera would lose frames meanwhile.
  std::unique_ptr<RunPublishing> publishing;     ///< Null unless asked for.
  std::unique_ptr<ServiceNotifier> service = std::make_unique<ServiceNotifier>();
};

/// Makes all of them, the run folder last; takes the setup's network. Failures name what could not be made.
[[nodiscard]] Outcome<RunComponents> make_components(RunSetup& setup, Arena& arena);

}  // namespace kinetrace::app

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
#include "segmentation/mask_fit_watch.hpp"
#include "segmentation/mask_mailbox.hpp"
#include "segmentation/network_thread.hpp"

namespace kinetrace::app {

/// In the order of processing. All memory is allocated at creation.
struct RunComponents {
  GuardedCamera camera;
  hal::Rectifier rectifier;
  std::unique_ptr<WorkerThreads> workers;  ///< Share the most expensive stages.
  std::unique_ptr<NetworkThread> network;  ///< Null without a neural network.
  std::unique_ptr<MaskMailbox> masks;      ///< Null unless masks come from another process.
  pipeline::Pipeline pipeline;
  recording::RunRecorder recorder;
  InputWatch input;
  std::optional<MaskFileWatch> mask_files;       ///< Present if masks come from files.
  std::optional<MaskFitWatch> mask_fit;          ///< Present if masks come from files or another process.
  std::unique_ptr<RecordingThread> raw;          ///< Null unless asked for.
  std::unique_ptr<RecordingThread> raw_ended{};  ///< The recording after it stopped early.
  bool refines_calibration = false;              ///< Refines and corrects.
  bool waits_for_disk = false;                   ///< True for recordings; a camera would lose frames meanwhile.
  std::unique_ptr<RunPublishing> publishing;     ///< Null unless asked for.
  std::unique_ptr<ServiceNotifier> service = std::make_unique<ServiceNotifier>();
};

/// Creates all components, the run folder last; takes over the setup's network. Failures name the component.
[[nodiscard]] Outcome<RunComponents> make_components(RunSetup& setup, Arena& arena);

}  // namespace kinetrace::app

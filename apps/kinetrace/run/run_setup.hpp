// Setup of a run, from the command line to the memory plan.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "camera/camera_setup.hpp"
#include "cli/failure.hpp"
#include "config/app_config.hpp"
#include "dds/run_publishing.hpp"
#include "plan/memory.hpp"
#include "run/run_options.hpp"
#include "segmentation/network_thread.hpp"

namespace kinetrace::app {

/// Read and checked before any memory is taken, in this order.
struct RunSetup {
  RunOptions options;
  AppConfig config;
  CameraSetup camera;
  std::unique_ptr<PublishingSetup> publishing;  ///< Null unless asked for.
  std::unique_ptr<NetworkThread> network;       ///< Null without a neural network ...
  std::optional<std::string> why_no_network;    ///< ... with the reason, if one was requested.
  RunMemory memory;                             ///< Within the budget.

  /// Failures name the fault of the options, the configuration, the recording or the plan.
  [[nodiscard]] static Outcome<RunSetup> create(const RunOptions& options);

  [[nodiscard]] bool is_live() const noexcept { return app::is_live(config.live, camera); }
  /// Every setting, also those of publishing, for run.json.
  [[nodiscard]] std::string settings_json();
};

}  // namespace kinetrace::app

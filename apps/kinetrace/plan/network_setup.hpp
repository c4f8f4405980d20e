// From the configuration to a neural network that is ready.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "config/app_config.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "plan/memory.hpp"
#include "segmentation/network_thread.hpp"

namespace kinetrace::app {

/// Null where there is none, and in words why, if segmentation.mode would have had one.
struct StartedNetwork {
  std::unique_ptr<NetworkThread> thread;
  std::optional<std::string> why_none;
};

/// What a run takes with this network, or with none.
using PlanRun = std::function<Result<RunMemory>(const AppConfig&, const NetworkThread*)>;

/// Starts the network that segmentation.mode needs. `auto` becomes `motion` in `config` where the network that comes
/// with Kinetrace cannot be loaded, and where memory.budget_mib does not hold the plan with a network: one that
/// certainly does not fit is not even loaded. `waits`: for a recording, whose frames wait for their masks. Errors:
/// those of `plan_run`, and those of load_model and NetworkThread::create for `onnx` or a model that the configuration
/// names.
[[nodiscard]] Result<StartedNetwork> start_network(AppConfig& config, const StereoGeometry& geometry, bool waits,
                                                   const PlanRun& plan_run);

/// As model_caution, of the configured network; none where segmentation.mode does not use one.
[[nodiscard]] std::optional<std::string> network_caution(const AppConfig& config,
                                                         const std::filesystem::path& pictures);

}  // namespace kinetrace::app

// Starts the configured neural network.
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

/// Null without a network; `why_none` has the reason if segmentation.mode allows one.
struct StartedNetwork {
  std::unique_ptr<NetworkThread> thread;
  std::optional<std::string> why_none;
};

/// Plans a run's memory with this network, or without one.
using PlanRun = std::function<Result<RunMemory>(const AppConfig&, const NetworkThread*)>;

/// Starts the network that segmentation.mode needs. `auto` becomes `motion` in `config` if the bundled network cannot
/// be loaded, or if the plan with a network exceeds memory.budget_mib; a network that certainly does not fit is not
/// loaded. `waits`: frames wait for their masks, as for recordings. Errors: those of `plan_run`, and those of
/// load_model and NetworkThread::create for `onnx` or a model that the configuration names.
[[nodiscard]] Result<StartedNetwork> start_network(AppConfig& config, const StereoGeometry& geometry, bool waits,
                                                   const PlanRun& plan_run);

/// model_caution of the configured network; none if segmentation.mode uses no network.
[[nodiscard]] std::optional<std::string> network_caution(const AppConfig& config,
                                                         const std::filesystem::path& pictures);

}  // namespace kinetrace::app

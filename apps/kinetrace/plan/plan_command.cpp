#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/messages.hpp"
#include "cli/shared_options.hpp"
#include "config/app_config.hpp"
#include "plan/board_camera.hpp"
#include "plan/memory.hpp"
#include "plan/network_setup.hpp"
#include "plan/setting_costs.hpp"

namespace kinetrace::app {
namespace {

struct PlanOptions {
  ConfigSource config;
  std::string publish;  ///< As for a run.
  std::string size;     ///< "WxH"; empty: the configured size.
};

std::string mib(double bytes) {
  constexpr double kMib = 1024.0 * 1024.0;
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%10.3f", bytes / kMib);
  return text.data();
}

void print_line(const std::string& name, double bytes, const std::string& depends_on) {
  std::printf("%-20s %s  %s\n", name.c_str(), mib(bytes).c_str(), depends_on.c_str());
}

void print_parts(const RunMemory& plan, const AppConfig& config) {
  const BoardConfig& board = config.board;
  std::printf("Memory for raw images of %dx%d pixels%s%s\n\n%-20s %10s  %s\n", board.image_width_px,
              board.image_height_px, board.name.empty() ? "" : " on ", board.name.c_str(), "part", "MiB",
              "size depends on");
  for (const MemoryPlan* part : {&plan.arena, &plan.outside}) {
    for (const MemoryPlanEntry& entry : part->entries) {
      print_line(entry.name, static_cast<double>(entry.bytes), entry.depends_on);
    }
  }
  print_line("total", static_cast<double>(plan.total_bytes()), "");
  const pipeline::MemoryConfig& memory = config.pipeline.memory;
  print_line("budget", budget_bytes(plan, memory),
             memory.budget_mib > 0.0 ? "memory.budget_mib" : "memory.budget_mib is 0: what the plan needs");
  if (board.memory_mib > 0) {
    print_line("board", board.memory_mib * 1024.0 * 1024.0, "board.memory_mib");
  }
}

void print_costs(const std::vector<SettingCost>& costs) {
  std::printf("\n%-34s %8s %10s  %s\n", "setting", "now", "MiB", "one more, or on, KiB");
  for (const SettingCost& cost : costs) {
    std::printf("%-34s %8s %s  %.2f\n", cost.key.c_str(), cost.value.c_str(), mib(cost.share_bytes).c_str(),
                cost.bytes / 1024.0);
  }
}

struct ImageSize {
  int width_px = 0;  ///< 0: the configured size.
  int height_px = 0;
};

Outcome<ImageSize> parse_size(const std::string& text) {
  ImageSize size;
  if (text.empty()) {
    return size;
  }
  char rest = 0;
  // NOLINTNEXTLINE(cert-err34-c): the bounds below reject values beyond int's range.
  const int fields = std::sscanf(text.c_str(), "%5dx%5d%c", &size.width_px, &size.height_px, &rest);
  const auto is_usable = [](int side_px) { return side_px >= 64 && side_px <= 8192; };
  if (fields != 2 || !is_usable(size.width_px) || !is_usable(size.height_px)) {
    return Unexpected(Failure{ExitCode::kUsage, "--size " + text + ": expected WIDTHxHEIGHT, 64 to 8192 pixels each"});
  }
  return size;
}

// Loads the configuration and applies --size.
Outcome<AppConfig> config_of(const PlanOptions& options) {
  const Outcome<ImageSize> size = parse_size(options.size);
  if (!size) {
    return Unexpected(size.error());
  }
  Result<AppConfig> config = load_config(options.config);
  if (!config) {
    return failure(config.error());
  }
  if (size->width_px > 0) {
    config->board.image_width_px = size->width_px;
    config->board.image_height_px = size->height_px;
  }
  return std::move(*config);
}

Result<RunMemory> plan_for(AppConfig config, const PublishingSetup* publishing, const NetworkThread* network) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  // The plan is for devices, which are live unless live mode is off.
  config.live.mode = config.live.mode == LiveMode::kOff ? LiveMode::kOff : LiveMode::kOn;
  return plan_memory(config, camera_of(config.board), {}, publishing, network);
}

// Inputs of a plan outside the arena, created once for all plans.
struct PlanInputs {
  std::unique_ptr<PublishingSetup> publishing;  ///< Null without --publish.
  std::unique_ptr<NetworkThread> network;       ///< Null without a network.
};

// Reports that `auto` has become motion alone.
Outcome<PlanInputs> inputs_of(const PlanOptions& options, AppConfig& config) {
  auto publishing = optional_publishing(options.publish, config.pipeline.tracking.max_objects);
  if (!publishing) {
    return Unexpected(publishing.error());
  }
  const auto geometry = hal::Rectifier::rectified_geometry(camera_of(config.board).calibration, config.rectification);
  if (!geometry) {
    return failure(geometry.error());
  }
  Result<StartedNetwork> network = start_network(
      config, *geometry, false,
      [&](const AppConfig& planned, const NetworkThread* with) { return plan_for(planned, publishing->get(), with); });
  if (!network) {
    return failure(network.error());
  }
  if (network->why_none) {
    print_warning(*network->why_none);
  }
  return PlanInputs{std::move(*publishing), std::move(network->thread)};
}

std::vector<SettingCost> costs_of(AppConfig config, const PlanInputs& inputs) {
  const ConfigFields fields = all_fields(fields_of(config), inputs.publishing.get());
  return setting_costs(fields, [&]() -> Result<double> {
    const Result<RunMemory> plan = plan_for(config, inputs.publishing.get(), inputs.network.get());
    return plan ? Result<double>(static_cast<double>(plan->total_bytes())) : Unexpected(plan.error());
  });
}

int plan_command(const PlanOptions& options) {
  Outcome<AppConfig> config = config_of(options);
  if (!config) {
    return report(config.error());
  }
  const Outcome<PlanInputs> inputs = inputs_of(options, *config);
  if (!inputs) {
    return report(inputs.error());
  }
  const Result<RunMemory> plan = plan_for(*config, inputs->publishing.get(), inputs->network.get());
  if (!plan) {
    return report(to_failure(plan.error()));
  }
  print_parts(*plan, *config);
  print_costs(costs_of(*config, *inputs));
  const Status fits = check_budget(*plan, config->pipeline.memory);
  return fits ? 0 : report(to_failure(fits.error()));
}

void add_options(CLI::App& plan, PlanOptions& options) {
  add_config_options(plan, options.config);
  add_publish_option(plan, options.publish);
  plan.add_option("--size", options.size,
                  "Size of one view's images; without it, the board's (board.image_width_px, ..._height_px)")
      ->type_name("WxH");
}

}  // namespace

Action add_plan(CLI::App& command) {
  return bind_options(command, add_options, plan_command);
}

}  // namespace kinetrace::app

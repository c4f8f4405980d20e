#include "plan/network_setup.hpp"

#include <algorithm>
#include <utility>

#include "kinetrace/segmentation/mask_fusion.hpp"
#include "segmentation/model_file.hpp"

namespace kinetrace::app {
namespace {

using segmentation::SegmentationMode;

/// Lower bounds of a network's memory, so that a network that cannot fit is not loaded: for the bundled one (53 MiB
/// with its largest input, less with smaller pictures; OpenCV 4.6), and for one of a few KiB.
constexpr std::size_t kShippedNetworkBytes = std::size_t{20} << 20U;
constexpr std::size_t kSmallestNetworkBytes = std::size_t{7} << 20U;

Result<std::unique_ptr<NetworkThread>> load_network(const AppConfig& config, const StereoGeometry& geometry,
                                                    bool waits) {
  const segmentation::SegmentationConfig& segmentation = config.pipeline.segmentation;
  const segmentation::NetworkConfig& onnx = segmentation.onnx;
  Result<neural::ModelConfig> model = load_model(onnx.model);
  if (!model) {
    return Unexpected(model.error());
  }
  if (segmentation.mode == SegmentationMode::kAuto) {
    model->thresholds.proposal = segmentation::kMinCandidateProbability;
  }
  return NetworkThread::create(
      {.model = std::move(*model), .threads = onnx.threads, .right = onnx.right, .waits = waits}, geometry);
}

/// Whether the budget suffices for a run with this network, or, if it is not loaded yet, with its lower bound.
Status check_room(const AppConfig& config, const NetworkThread* network, const PlanRun& plan_run) {
  Result<RunMemory> memory = plan_run(config, network);
  if (!memory) {
    return Unexpected(memory.error());
  }
  if (network == nullptr) {
    const bool is_shipped = config.pipeline.segmentation.onnx.model.empty();
    memory->outside.entries.push_back(
        {"neural network", is_shipped ? kShippedNetworkBytes : kSmallestNetworkBytes, ""});
  }
  return check_budget(*memory, config.pipeline.memory);
}

StartedNetwork without_network(AppConfig& config, const Error& why) {
  config.pipeline.segmentation.mode = SegmentationMode::kMotion;
  return {nullptr, "segmentation auto finds objects by their motion alone, without a neural network: " + why.message};
}

Result<StartedNetwork> start_if_it_fits(AppConfig& config, const StereoGeometry& geometry, bool waits,
                                        const PlanRun& plan_run) {
  if (const Status room = check_room(config, nullptr, plan_run); !room) {
    return room.error().code == ErrorCode::kBudget ? Result<StartedNetwork>(without_network(config, room.error()))
                                                   : Unexpected(room.error());
  }
  Result<std::unique_ptr<NetworkThread>> network = load_network(config, geometry, waits);
  if (!network) {
    return config.pipeline.segmentation.onnx.model.empty()
               ? Result<StartedNetwork>(without_network(config, network.error()))
               : Unexpected(network.error());
  }
  if (const Status room = check_room(config, network->get(), plan_run); !room) {
    return without_network(config, room.error());
  }
  return StartedNetwork{std::move(*network), std::nullopt};
}

}  // namespace

Result<StartedNetwork> start_network(AppConfig& config, const StereoGeometry& geometry, bool waits,
                                     const PlanRun& plan_run) {
  switch (config.pipeline.segmentation.mode) {
    case SegmentationMode::kAuto: return start_if_it_fits(config, geometry, waits, plan_run);
    case SegmentationMode::kOnnx: {
      Result<std::unique_ptr<NetworkThread>> network = load_network(config, geometry, waits);
      return network ? Result<StartedNetwork>(StartedNetwork{std::move(*network), std::nullopt})
                     : Unexpected(network.error());
    }
    default: return StartedNetwork{};
  }
}

std::optional<std::string> network_caution(const AppConfig& config, const std::filesystem::path& pictures) {
  if (!segmentation::uses_network(config.pipeline.segmentation.mode)) {
    return std::nullopt;
  }
  const Result<neural::ModelConfig> model = load_model(config.pipeline.segmentation.onnx.model);
  return model ? model_caution(*model, pictures) : std::nullopt;
}

}  // namespace kinetrace::app

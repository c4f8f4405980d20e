#include "segmentation/network_setup.hpp"

#include <utility>

#include "segmentation/model_file.hpp"

namespace kinetrace::app {

Result<std::unique_ptr<NetworkThread>> start_network(const AppConfig& config, const StereoGeometry& geometry,
                                                     bool waits) {
  if (config.pipeline.segmentation.mode != segmentation::SegmentationMode::kOnnx) {
    return nullptr;
  }
  const segmentation::NetworkConfig& onnx = config.pipeline.segmentation.onnx;
  Result<neural::ModelConfig> model = load_model(onnx.model);
  if (!model) {
    return Unexpected(model.error());
  }
  return NetworkThread::create(
      {.model = std::move(*model), .threads = onnx.threads, .right = onnx.right, .waits = waits}, geometry);
}

std::optional<std::string> network_caution(const AppConfig& config, const std::filesystem::path& pictures) {
  if (config.pipeline.segmentation.mode != segmentation::SegmentationMode::kOnnx) {
    return std::nullopt;
  }
  const Result<neural::ModelConfig> model = load_model(config.pipeline.segmentation.onnx.model);
  return model ? model_caution(*model, pictures) : std::nullopt;
}

}  // namespace kinetrace::app

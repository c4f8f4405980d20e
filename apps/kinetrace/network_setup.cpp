#include "network_setup.hpp"

#include <utility>

#include "model_file.hpp"

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

}  // namespace kinetrace::app

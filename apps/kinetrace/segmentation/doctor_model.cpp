#include "segmentation/doctor_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "segmentation/model_file.hpp"

namespace kinetrace::app {
namespace {

constexpr int kFrames = 8;

double time_ms(NetworkThread& network, const StereoGeometry& geometry) {
  const std::vector<std::uint8_t> pixels(
      static_cast<std::size_t>(geometry.width_px) * static_cast<std::size_t>(geometry.height_px), 128);
  const GrayView image{pixels.data(), geometry.width_px, geometry.height_px, geometry.width_px};
  RectifiedPair pair;
  pair.left = image;
  pair.right = image;
  pair.geometry = geometry;
  for (int i = 0; i < kFrames; ++i) {
    network.offer(pair, {});
    static_cast<void>(network.take());
  }
  return network.counters().median_ms;
}

}  // namespace

ModelFinding examine_model(const AppConfig& config, NetworkThread& network, const StereoGeometry& geometry,
                           double rate_hz) {
  const segmentation::NetworkConfig& onnx = config.pipeline.segmentation.onnx;
  const Result<neural::ModelConfig> model = load_model(onnx.model);
  if (!model) {
    return {false, model.error().message};
  }
  const neural::ModelInput input = model->input.sized_for(geometry.width_px, geometry.height_px);
  const double took_ms = time_ms(network, geometry);
  const int needed_frames = static_cast<int>(std::ceil(took_ms * rate_hz / 1e3));
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(),
                "%s: %dx%d, %d thread%s, %.1f ms a frame, %.1f MiB; at %.3g Hz masks come %d frame%s late",
                std::filesystem::path(model->file).filename().c_str(), input.width_px, input.height_px, onnx.threads,
                onnx.threads == 1 ? "" : "s", took_ms, static_cast<double>(network.bytes()) / (1024.0 * 1024.0),
                rate_hz, needed_frames, needed_frames == 1 ? "" : "s");
  const bool is_in_time = needed_frames <= std::max(1, onnx.latency_frames);
  const bool only_helps = config.pipeline.segmentation.mode == segmentation::SegmentationMode::kAuto;
  return {is_in_time || only_helps,
          std::string(text.data()) + (is_in_time ? ""
                                                 : "; set segmentation.onnx.latency_frames to that, give "
                                                   "it more threads, or take a smaller input")};
}

}  // namespace kinetrace::app

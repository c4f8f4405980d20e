// The whole pipeline, per frame, on a rendered 1242x375 street: the background alone, and with eight masked objects.
#include <cmath>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/pipeline/pipeline.hpp"
#include "street_drive.hpp"

namespace kinetrace::pipeline {
namespace {

using segmentation::SegmentationMode;
using test::Mover;
using test::RenderedPair;
using test::StreetDrive;

constexpr int kFrames = 40;

StereoGeometry wide_rig() {
  return {.fx_px = 721.0,
          .fy_px = 721.0,
          .cx_px = 609.0,
          .cy_px = 173.0,
          .baseline_m = 0.54,
          .width_px = 1242,
          .height_px = 375};
}

/// Eight boxes side by side in the image, nearer ones at its borders, driving ahead of the camera.
std::vector<Mover> traffic() {
  std::vector<Mover> movers;
  for (int i = 0; i < 8; ++i) {
    const double tangent = -0.56 + 0.17 * i;
    const double depth_m = 16.0 - 14.0 * std::abs(tangent);
    movers.push_back({.size_m = {1.2, 1.5, 2.0},
                      .start_m = {tangent * depth_m, 0.75, depth_m + 1.0},
                      .velocity_mps = {0.1, 0.0, 5.5}});
  }
  return movers;
}

struct Footage {
  explicit Footage(std::vector<Mover> movers) : street(std::move(movers), wide_rig()) {
    for (int frame = 0; frame < kFrames; ++frame) {
      pairs.push_back(street.render(frame));
      stems.push_back(test::stem_of(frame));
      masks.write(pairs.back(), frame);
    }
  }
  StreetDrive street;
  std::vector<RenderedPair> pairs;
  std::vector<std::string> stems;
  test::MaskFolder masks;
};

void whole_chain(benchmark::State& state, SegmentationMode mode, int objects) {
  std::vector<Mover> movers = traffic();
  movers.resize(static_cast<std::size_t>(objects));
  const Footage footage(movers);
  PipelineConfig config;
  config.segmentation.mode = mode;
  config.segmentation.left_dir = footage.masks.left().string();
  config.segmentation.right_dir = footage.masks.right().string();
  Arena arena(Pipeline::plan(config, wide_rig()).value().total_bytes());
  Pipeline pipeline = Pipeline::create(config, wide_rig(), arena).value();
  // The clip runs forwards and backwards, so that no object jumps; the first pass warms up.
  std::int64_t index = 0;
  const auto next = [&] {
    const auto turn = static_cast<int>(index % (2 * kFrames - 2));
    const auto frame = static_cast<std::size_t>(turn < kFrames ? turn : 2 * kFrames - 2 - turn);
    return pipeline.process(footage.pairs[frame].at(index++, footage.stems[frame])).value();
  };
  for (int frame = 0; frame < kFrames; ++frame) {
    next();
  }
  std::size_t reported = 0;
  for ([[maybe_unused]] auto iteration : state) {
    reported += next()->newest.objects.size();
  }
  state.counters["objects"] = benchmark::Counter(static_cast<double>(reported), benchmark::Counter::kAvgIterations);
}

BENCHMARK_CAPTURE(whole_chain, background, SegmentationMode::kNone, 0)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(whole_chain, motion_8_objects, SegmentationMode::kMotion, 8)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(whole_chain, masks_8_objects, SegmentationMode::kMasks, 8)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kinetrace::pipeline

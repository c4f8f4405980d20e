// Windowed bundle adjustment: the fixed-size solver and Ceres with analytic derivatives on the same windows.
#include <benchmark/benchmark.h>

#include "bundle_scene.hpp"
#include "kinetrace/refinement/ceres_bundle_adjuster.hpp"
#include "kinetrace/refinement/fixed_bundle_adjuster.hpp"

namespace kinetrace::refinement {
namespace {

constexpr int kIterations = 5;

BundleScene scene_of(const benchmark::State& state) {
  SceneOptions options;
  options.frames = static_cast<int>(state.range(0));
  options.points = static_cast<int>(state.range(1));
  return make_scene(options);
}

void run(benchmark::State& state, BundleAdjuster& adjuster) {
  const BundleScene scene = scene_of(state);
  BundleScene work = scene;
  double cost = 0.0;
  for ([[maybe_unused]] auto iteration : state) {
    state.PauseTiming();
    work = scene;
    BundleWindow window = work.window();
    state.ResumeTiming();
    const Result<BundleSummary> summary = adjuster.refine(window);
    cost = summary ? summary->final_cost : -1.0;
    benchmark::DoNotOptimize(cost);
  }
  state.counters["final_cost"] = cost;
}

void fixed_solver(benchmark::State& state) {
  FixedBundleConfig config;
  config.max_iterations = kIterations;
  config.relative_cost_tolerance = 0.0;
  Arena arena(FixedBundleAdjuster::required_bytes(config));
  Result<FixedBundleAdjuster> adjuster = FixedBundleAdjuster::create(config, arena);
  run(state, *adjuster);
}

void ceres_solver(benchmark::State& state) {
  CeresBundleConfig config;
  config.max_iterations = kIterations;
  config.relative_cost_tolerance = 0.0;
  Result<CeresBundleAdjuster> adjuster = CeresBundleAdjuster::create(config);
  run(state, *adjuster);
}

BENCHMARK(fixed_solver)->Args({10, 500})->Args({6, 60})->Unit(benchmark::kMicrosecond);
BENCHMARK(ceres_solver)->Args({10, 500})->Args({6, 60})->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace kinetrace::refinement

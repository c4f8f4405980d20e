// Handing over one result, the only cost of publishing to the pipeline: 64 objects and 2000 points. tests/dds
// measures sending, with a reader.
#include <memory>

#include <benchmark/benchmark.h>

#include "kinetrace/core/allocation_counter.hpp"
#include "kinetrace/publishing/result_mailbox.hpp"
#include "sample_results.hpp"

namespace kinetrace::publishing {
namespace {

void offer_result(benchmark::State& state) {
  const test::SampleResult sample({.objects = 64, .background_points = 1360, .points_per_object = 10});
  const PublishConfig config;
  Arena arena(ResultMailbox::required_bytes(config));
  const auto mailbox = ResultMailbox::create(config, arena);
  const AllocationCounts before = allocation_counts();
  for (auto _ : state) {
    (*mailbox)->offer(sample.result, 1);
    for (TrajectoryEvent event; (*mailbox)->fetch(event);) {
      benchmark::DoNotOptimize(event);
    }
  }
  state.counters["allocations"] = static_cast<double>(allocation_counts().own - before.own);
}
BENCHMARK(offer_result)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace kinetrace::publishing

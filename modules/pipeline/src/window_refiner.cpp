#include "window_refiner.hpp"

namespace kinetrace::pipeline {

using refinement::FixedBundleAdjuster;

std::size_t WindowRefiner::required_bytes(const refinement::FixedBundleConfig& config) {
  return kAdjusters * FixedBundleAdjuster::required_bytes(config);
}

Result<WindowRefiner> WindowRefiner::create(const refinement::FixedBundleConfig& config, Arena& arena,
                                            Workers* workers) {
  auto first = FixedBundleAdjuster::create(config, arena);
  if (!first) {
    return Unexpected(first.error());
  }
  auto second = FixedBundleAdjuster::create(config, arena);
  if (!second) {
    return Unexpected(second.error());
  }
  return WindowRefiner(std::move(*first), std::move(*second), workers);
}

Status WindowRefiner::refine_next(FixedBundleAdjuster& adjuster, std::span<BodyRefinement> bodies,
                                  std::atomic<std::size_t>& next) {
  for (std::size_t i = next.fetch_add(1, std::memory_order_relaxed); i < bodies.size();
       i = next.fetch_add(1, std::memory_order_relaxed)) {
    BundleWindow window = bodies[i].body->window();
    const Result<BundleSummary> summary = adjuster.refine(window);
    if (!summary) {
      return Unexpected(summary.error());
    }
    bodies[i].summary = *summary;
  }
  return {};
}

Status WindowRefiner::refine(std::span<BodyRefinement> bodies) {
  std::atomic<std::size_t> next{0};
  if (workers_ == nullptr || bodies.size() < 2) {
    return refine_next(adjusters_[0], bodies, next);
  }
  std::array<Status, kAdjusters> done;
  auto take_part = [&](std::size_t worker) {
    if (worker < kAdjusters) {
      done[worker] = refine_next(adjusters_[worker], bodies, next);
    }
  };
  workers_->run(Job(take_part));
  return done[0] ? done[1] : done[0];
}

void WindowRefiner::limit(int max_iterations) noexcept {
  for (FixedBundleAdjuster& adjuster : adjusters_) {
    adjuster.limit(max_iterations);
  }
}

}  // namespace kinetrace::pipeline

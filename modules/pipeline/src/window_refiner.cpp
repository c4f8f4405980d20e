#include "window_refiner.hpp"

#include <algorithm>
#include <atomic>
#include <utility>

namespace kinetrace::pipeline {

using refinement::FixedBundleAdjuster;

namespace {

constexpr int kMinFrames = 2;  // Minimum of an adjuster; windows of one frame are not adjusted.

refinement::FixedBundleConfig for_objects(refinement::FixedBundleConfig config, const sfm::BodyConfig& object) {
  config.max_frames = std::max(object.window_frames, kMinFrames);
  config.max_points = object.max_points;
  return config;
}

}  // namespace

std::size_t WindowRefiner::required_bytes(const refinement::FixedBundleConfig& largest, const sfm::BodyConfig& object) {
  return FixedBundleAdjuster::required_bytes(largest) +
         FixedBundleAdjuster::required_bytes(for_objects(largest, object));
}

Result<WindowRefiner> WindowRefiner::create(const refinement::FixedBundleConfig& largest, const sfm::BodyConfig& object,
                                            Arena& arena, Workers* workers) {
  auto first = FixedBundleAdjuster::create(largest, arena);
  if (!first) {
    return Unexpected(first.error());
  }
  auto second = FixedBundleAdjuster::create(for_objects(largest, object), arena);
  if (!second) {
    return Unexpected(second.error());
  }
  return WindowRefiner(std::move(*first), std::move(*second), workers);
}

Status WindowRefiner::refine_one(FixedBundleAdjuster& adjuster, BodyRefinement& body) {
  BundleWindow window = body.body->window();
  const Result<BundleSummary> summary = adjuster.refine(window);
  if (!summary) {
    return Unexpected(summary.error());
  }
  body.summary = *summary;
  return {};
}

Status WindowRefiner::refine(std::span<BodyRefinement> bodies) {
  std::atomic<std::size_t> next{1};
  std::array<Status, kAdjusters> done;
  auto take_part = [&](std::size_t worker) {
    if (worker >= kAdjusters) {
      return;
    }
    FixedBundleAdjuster& adjuster = adjusters_[worker];
    if (worker == 0 && !bodies.empty()) {
      done[0] = refine_one(adjuster, bodies[0]);  // Only the first adjuster is large enough.
    }
    for (std::size_t i = next.fetch_add(1); i < bodies.size() && done[worker]; i = next.fetch_add(1)) {
      done[worker] = refine_one(adjuster, bodies[i]);
    }
  };
  if (workers_ == nullptr || bodies.size() < 2) {
    take_part(0);
  } else {
    workers_->run(Job(take_part));
  }
  return done[0] ? done[1] : done[0];
}

void WindowRefiner::limit(int max_iterations) noexcept {
  for (FixedBundleAdjuster& adjuster : adjusters_) {
    adjuster.limit(max_iterations);
  }
}

}  // namespace kinetrace::pipeline

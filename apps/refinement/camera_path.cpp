#include "camera_path.hpp"

#include <array>
#include <cstdio>
#include <memory>

#include "figure/figure_images.hpp"
#include "loops/loop_closure.hpp"

namespace kinetrace::batch {
namespace {

using app::failure;
using app::Outcome;
using app::RefineOptions;

/// Errors: those of the recording's images.
Result<std::vector<Loop>> loops_of(const recording::Run& run, const ObservedPath& path, const RefineOptions& options,
                                   const AdjustmentOptions& adjustment, const RefinedCamera& camera,
                                   RefineProgress& progress) {
  std::unique_ptr<figure::RecordedImages> images;
  const auto pair = [&](std::int64_t frame) -> Result<RectifiedPair> {
    if (images == nullptr) {
      Result<figure::RecordedImages> opened = figure::RecordedImages::open(run, options.dataset);
      if (!opened) {
        return Unexpected(opened.error());
      }
      images = std::make_unique<figure::RecordedImages>(std::move(*opened));
    }
    return images->pair(frame);
  };
  return find_loops(run, camera.T_world_cam, path.keyframes, pair, adjustment,
                    [&](double part) { progress.loops(part); });
}

/// Adds them to the graph. A recording that is not where the run says is no error, unless it was named.
Outcome<PathCorrection> close_loops(const recording::Run& run, const ObservedPath& path, const RefineOptions& options,
                                    const AdjustmentOptions& adjustment, PathGraph& graph, RefinedCamera& camera,
                                    RefineProgress& progress) {
  PathCorrection correction;
  Result<std::vector<Loop>> loops = loops_of(run, path, options, adjustment, camera, progress);
  if (!loops && !options.dataset.empty()) {
    return failure(loops.error());
  }
  if (!loops) {
    correction.notes.push_back("places that the camera saw twice were not looked for: " + loops.error().message +
                               "; --dataset LAYOUT:PATH says where the recording lies, --no-loops leaves them out");
    return correction;
  }
  graph.loops = std::move(*loops);
  correction.loops = graph.loops.size();
  if (correction.loops > 0) {
    Result<BentPath> bent = bend_path(run.rectified, graph, {}, adjustment);
    if (!bent) {
      return failure(bent.error());
    }
    std::array<char, 128> text;
    std::snprintf(text.data(), text.size(), "Closed %zu loops, which moved the path by up to %.2f m", correction.loops,
                  move_camera(std::move(*bent), camera));
    correction.results.emplace_back(text.data());
  }
  return correction;
}

}  // namespace

Outcome<PathCorrection> correct_path(const recording::Run& run, const RefineOptions& options,
                                     const AdjustmentOptions& adjustment, const HoldPath& hold, RefinedCamera& camera,
                                     RefineProgress& progress) {
  if (!adjustment.keep_going() || (!options.loops && !hold)) {
    return PathCorrection{};
  }
  Result<ObservedPath> path = observe_path(run, camera.T_world_cam, camera.sigma_px);
  if (!path) {
    return failure(path.error());
  }
  PathGraph graph{camera.T_world_cam, path->step_information};
  Outcome<PathCorrection> correction =
      options.loops ? close_loops(run, *path, options, adjustment, graph, camera, progress) : PathCorrection{};
  if (correction && hold) {
    const Outcome<HeldPath> held = hold(graph, camera);
    if (!held) {
      return Unexpected(held.error());
    }
    correction->scale = held->scale;
    correction->results.push_back(held->result);
  }
  return correction;
}

}  // namespace kinetrace::batch

#include "camera_path.hpp"

#include <array>
#include <cstdio>

#include "loops/loop_closure.hpp"

namespace kinetrace::batch {
namespace {

using app::failure;
using app::Outcome;

/// Finds loops, adds them to the graph and bends the path.
Outcome<PathCorrection> close_loops(const recording::Run& run, const ObservedPath& path, const LoopSearch& search,
                                    const AdjustmentOptions& adjustment, PathGraph& graph, RefinedCamera& camera) {
  Result<std::vector<Loop>> loops = find_loops(run, camera.T_world_cam, path.keyframes, search.read, adjustment,
                                               [&](double part) { search.progress.loops(part); });
  if (!loops) {
    return failure(loops.error());
  }
  PathCorrection correction;
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

Outcome<PathCorrection> correct_path(const recording::Run& run, const MeasuredBackground& measured,
                                     const LoopSearch& search, const HoldPath& hold,
                                     const AdjustmentOptions& adjustment, RefinedCamera& camera) {
  if (!adjustment.keep_going() || (!search.read && !hold)) {
    return PathCorrection{};
  }
  Result<ObservedPath> path = observe_path(run, measured, camera.T_world_cam, camera.sigma_px);
  if (!path) {
    return failure(path.error());
  }
  PathGraph graph{camera.T_world_cam, path->step_information};
  Outcome<PathCorrection> correction =
      search.read ? close_loops(run, *path, search, adjustment, graph, camera) : PathCorrection{};
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

#include "loop_closure.hpp"

#include <algorithm>

#include <Eigen/Cholesky>

#include "kinetrace/refinement/ceres_bundle_adjuster.hpp"
#include "revisits.hpp"

namespace kinetrace::batch {
namespace {

/// U with U^T U = information.
Matrix6d root_of(const Matrix6d& information) {
  return information.llt().matrixU();
}

Result<std::vector<Loop>> find_loops(const recording::Run& run, const PairReader& read,
                                     const AdjustmentOptions& options, const std::vector<Keyframe>& keyframes,
                                     std::span<const Se3> T_world_cam, const std::function<void(double)>& progress) {
  const std::vector<std::vector<std::size_t>> revisits = find_revisits(keyframes, T_world_cam);
  PlaceMatcher matcher(run, T_world_cam, read, options);
  std::vector<Loop> loops;
  for (std::size_t now = 0; now < keyframes.size() && options.keep_going(); ++now) {
    if (revisits[now].empty()) {
      continue;
    }
    const Result<std::optional<Loop>> loop = matcher.match(keyframes, now, revisits[now]);
    if (!loop) {
      return Unexpected(loop.error());
    }
    if (*loop) {
      loops.push_back(**loop);
    }
    progress(static_cast<double>(now + 1) / static_cast<double>(keyframes.size()));
  }
  return loops;
}

}  // namespace

Status bend_path(const StereoGeometry& geometry, std::span<const Matrix6d> step_information,
                 std::span<const Loop> loops, const AdjustmentOptions& options, std::span<Se3> T_world_cam) {
  std::vector<refinement::BatchStep> steps;
  for (std::uint32_t row = 1; row < T_world_cam.size(); ++row) {
    steps.push_back({row - 1, row, T_world_cam[row - 1].inverse() * T_world_cam[row], root_of(step_information[row])});
  }
  std::vector<refinement::BatchStep> closing;
  for (const Loop& loop : loops) {
    closing.push_back({static_cast<std::uint32_t>(loop.from_row), static_cast<std::uint32_t>(loop.to_row),
                       loop.T_from_to, root_of(loop.information)});
  }
  const std::array<std::uint32_t, 1> fixed{0};
  refinement::BatchProblem problem{.geometry = geometry,
                                   .T_body_cam = T_world_cam,
                                   .fixed_frames = fixed,
                                   .points_m = {},
                                   .observations = {},
                                   .measured_steps = steps,
                                   .loops = closing};
  auto adjuster = refinement::CeresBundleAdjuster::create(
      {.max_iterations = 100, .threads = options.threads, .keep_going = options.keep_going});
  if (!adjuster) {
    return Unexpected(adjuster.error());
  }
  const auto solved = adjuster->refine_batch(problem);
  return solved ? Status() : Unexpected(solved.error());
}

Result<ClosedLoops> close_loops(const recording::Run& run, const PairReader& read, const AdjustmentOptions& options,
                                RefinedCamera& camera, const std::function<void(double)>& progress) {
  const Result<ObservedPath> path = observe_path(run, camera.T_world_cam, camera.sigma_px);
  if (!path) {
    return Unexpected(path.error());
  }
  const Result<std::vector<Loop>> loops = find_loops(run, read, options, path->keyframes, camera.T_world_cam, progress);
  if (!loops) {
    return Unexpected(loops.error());
  }
  if (loops->empty()) {
    return ClosedLoops{};
  }
  std::vector<Se3> bent = camera.T_world_cam;
  if (const Status bent_path = bend_path(run.rectified, path->step_information, *loops, options, bent); !bent_path) {
    return Unexpected(bent_path.error());
  }
  ClosedLoops closed{.loops = loops->size()};
  for (std::size_t row = 0; row < bent.size(); ++row) {
    closed.moved_m = std::max(closed.moved_m, (bent[row].translation - camera.T_world_cam[row].translation).norm());
  }
  for (RefinedPoint& point : camera.points) {
    point.position_m = bent[point.last_frame] * (camera.T_world_cam[point.last_frame].inverse() * point.position_m);
  }
  camera.T_world_cam = std::move(bent);
  return closed;
}

}  // namespace kinetrace::batch

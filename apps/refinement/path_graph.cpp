#include "path_graph.hpp"

#include <algorithm>
#include <array>

#include <Eigen/Cholesky>

namespace kinetrace::batch {
namespace {

/// U with U^T U = information.
Matrix6d root_of(const Matrix6d& information) {
  return information.llt().matrixU();
}

std::vector<refinement::BatchStep> steps_of(const PathGraph& graph) {
  std::vector<refinement::BatchStep> steps;
  const std::vector<Se3>& T_world_cam = graph.T_world_cam;
  steps.reserve(T_world_cam.size());
  for (std::uint32_t row = 1; row < T_world_cam.size(); ++row) {
    steps.push_back(
        {row - 1, row, T_world_cam[row - 1].inverse() * T_world_cam[row], root_of(graph.step_information[row])});
  }
  return steps;
}

std::vector<refinement::BatchStep> closing_steps(const std::vector<Loop>& loops) {
  std::vector<refinement::BatchStep> steps;
  steps.reserve(loops.size());
  for (const Loop& loop : loops) {
    steps.push_back({static_cast<std::uint32_t>(loop.from_row), static_cast<std::uint32_t>(loop.to_row), loop.T_from_to,
                     root_of(loop.information)});
  }
  return steps;
}

}  // namespace

Result<BentPath> bend_path(const StereoGeometry& geometry, const PathGraph& graph, const MapFixes& map,
                           const AdjustmentOptions& options) {
  const std::vector<refinement::BatchStep> steps = steps_of(graph);
  const std::vector<refinement::BatchStep> loops = closing_steps(graph.loops);
  std::vector<Se3> poses = graph.T_world_cam;
  std::vector<refinement::BatchFix> fixes = map.fixes;
  if (!fixes.empty()) {
    poses.push_back(map.T_map_world.inverse());
  }
  for (refinement::BatchFix& fix : fixes) {
    fix.map = static_cast<std::uint32_t>(graph.T_world_cam.size());
    fix.antenna_m = map.antenna_m;
  }
  const std::array<std::uint32_t, 1> fixed{0};
  refinement::BatchProblem problem{.geometry = geometry,
                                   .T_body_cam = poses,
                                   .fixed_frames = fixed,
                                   .points_m = {},
                                   .observations = {},
                                   .measured_steps = steps,
                                   .loops = loops,
                                   .scale = {1.0, map.scale_sigma},
                                   .fixes = fixes};
  auto adjuster = refinement::CeresBundleAdjuster::create(
      {.max_iterations = 100, .threads = options.threads, .keep_going = options.keep_going});
  if (!adjuster) {
    return Unexpected(adjuster.error());
  }
  const auto solved = adjuster->refine_batch(problem);
  if (!solved) {
    return Unexpected(solved.error());
  }
  const Se3 T_map_world = fixes.empty() ? Se3{} : poses.back().inverse();
  poses.resize(graph.T_world_cam.size());
  return BentPath{std::move(poses), T_map_world, problem.scale.value};
}

double move_camera(BentPath path, RefinedCamera& camera) {
  double moved_m = 0.0;
  for (std::size_t row = 0; row < path.T_world_cam.size(); ++row) {
    moved_m = std::max(moved_m, (path.T_world_cam[row].translation - camera.T_world_cam[row].translation).norm());
  }
  for (RefinedPoint& point : camera.points) {
    const std::size_t row = point.last_frame;
    const Eigen::Vector3d seen_m = camera.T_world_cam[row].inverse() * point.position_m;
    point.position_m = path.T_world_cam[row] * (path.scale * seen_m);
  }
  camera.T_world_cam = std::move(path.T_world_cam);
  return moved_m;
}

}  // namespace kinetrace::batch

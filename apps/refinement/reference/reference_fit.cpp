#include "reference_fit.hpp"

#include <algorithm>
#include <cmath>

namespace kinetrace::batch {
namespace {

constexpr int kMaxRounds = 8;
// Negligible on any map.
constexpr double kConverged_m = 0.005;

/// `T_level_world`: to a world levelled as in the first alignment.
Result<geo::Alignment> align(const recording::Run& run, const std::vector<Se3>& T_world_cam, const Se3& T_level_world,
                             std::span<const geo::Fix> fixes, const geo::AlignmentConfig& config) {
  std::vector<geo::PathPose> path;
  for (std::size_t row = 0; row < T_world_cam.size(); ++row) {
    path.push_back({run.camera[row].timestamp_ns, T_level_world * T_world_cam[row]});
  }
  Result<geo::Alignment> alignment = geo::align(path, fixes, config);
  if (alignment) {
    alignment->T_map_world = alignment->T_map_world * T_level_world;
  }
  if (alignment && alignment->verdict == geo::Verdict::kRefused) {
    return fail(ErrorCode::kBadFormat, "the reference does not hold the path: " + alignment->reason);
  }
  return alignment;
}

MapFixes factors(const recording::Run& run, std::span<const geo::Fix> fixes, const geo::AlignmentConfig& config,
                 const geo::Alignment& alignment) {
  MapFixes map{.T_map_world = alignment.T_map_world, .antenna_m = config.lever_arm_m, .scale_sigma = config.path_drift};
  const Eigen::Vector3d factor = alignment.sigma_factor * std::sqrt(alignment.correlation);
  const auto is_before = [](const recording::CameraRow& row, std::int64_t time_ns) {
    return row.timestamp_ns < time_ns;
  };
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    if (alignment.use[i] != geo::FixUse::kInlier) {
      continue;
    }
    const std::int64_t time_ns = fixes[i].time_ns + std::llround(1e9 * alignment.time_offset_s);
    const auto after = std::lower_bound(run.camera.begin(), run.camera.end(), time_ns, is_before);
    if (after == run.camera.begin() || after == run.camera.end()) {
      continue;
    }
    const auto row = static_cast<std::uint32_t>(after - run.camera.begin());
    const double interval_ns = static_cast<double>(after->timestamp_ns - run.camera[row - 1].timestamp_ns);
    map.fixes.push_back({.before = row - 1,
                         .after = row,
                         .part = static_cast<double>(time_ns - run.camera[row - 1].timestamp_ns) / interval_ns,
                         .position_m = fixes[i].enu_m,
                         .inverse_sigma = fixes[i].sigma_m.cwiseProduct(factor).cwiseInverse()});
  }
  return map;
}

}  // namespace

Result<ReferenceFit> fit_to_reference(const recording::Run& run, std::span<const geo::Fix> fixes,
                                      const geo::AlignmentConfig& asked, const PathGraph& graph,
                                      const AdjustmentOptions& options, RefinedCamera& camera) {
  geo::AlignmentConfig config = asked;
  // Drift that bending takes out counts as noise before.
  config.max_rotation_sigma_rad = 2.0 * M_PI;
  BentPath path{camera.T_world_cam, {}};
  Se3 T_level_world;
  Result<geo::Alignment> alignment = align(run, path.T_world_cam, T_level_world, fixes, config);
  const Se3 T_level_map = alignment ? alignment->T_map_world.inverse() : Se3{};
  for (int round = 0; alignment && round < kMaxRounds && options.keep_going(); ++round) {
    Result<BentPath> bent = bend_path(run.rectified, graph, factors(run, fixes, config, *alignment), options);
    if (!bent) {
      return Unexpected(bent.error());
    }
    double moved_m = 0.0;
    for (std::size_t row = 0; row < path.T_world_cam.size(); ++row) {
      moved_m = std::max(moved_m, (bent->T_world_cam[row].translation - path.T_world_cam[row].translation).norm());
    }
    path = std::move(*bent);
    T_level_world = T_level_map * path.T_map_world;
    alignment = align(run, path.T_world_cam, T_level_world, fixes, config);
    if (moved_m < kConverged_m) {
      break;
    }
  }
  // After an interrupt the path still has the drift that bending takes out.
  if (alignment && options.keep_going()) {
    config.max_rotation_sigma_rad = asked.max_rotation_sigma_rad;
    // The rotation of the map about a straight path does not matter for bending.
    config.roll_matters = false;
    alignment = align(run, path.T_world_cam, T_level_world, fixes, config);
  }
  if (!alignment) {
    return Unexpected(alignment.error());
  }
  const double scale = path.scale;
  return ReferenceFit{std::move(*alignment), move_camera(std::move(path), camera), scale};
}

}  // namespace kinetrace::batch

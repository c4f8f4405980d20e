#include "run_trajectories.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Eigenvalues>

#include "kinetrace/core/class_name.hpp"

namespace kinetrace::map {
namespace {

using geo::Alignment;
using geo::MapPoint;
using geo::MapTrajectory;

/// Clockwise from north; 0 for a vertical direction.
double heading_deg(const Eigen::Vector3d& direction_enu) {
  const double angle_deg = std::atan2(direction_enu.x(), direction_enu.y()) * 180.0 / M_PI;
  return angle_deg < 0.0 ? angle_deg + 360.0 : angle_deg;
}

double horizontal_sigma_m(const Alignment& alignment, const Eigen::Vector3d& enu_m) {
  const Eigen::Matrix2d covariance = position_covariance(alignment, enu_m).topLeftCorner<2, 2>();
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance).eigenvalues()[1]);
}

/// Between the neighbouring frames, if there are any.
Eigen::Vector3d camera_velocity(const std::vector<recording::CameraRow>& rows, std::size_t i) {
  const auto& before = rows[i > 0 ? i - 1 : i];
  const auto& after = rows[i + 1 < rows.size() ? i + 1 : i];
  const double step_s = static_cast<double>(after.timestamp_ns - before.timestamp_ns) * 1e-9;
  return step_s > 0.0 ? Eigen::Vector3d((after.T_world_cam.translation - before.T_world_cam.translation) / step_s)
                      : Eigen::Vector3d::Zero();
}

MapPoint map_point(const Alignment& alignment, const Eigen::Vector3d& world_m, const Eigen::Vector3d& velocity_mps,
                   const Eigen::Vector3d& forward) {
  const Eigen::Matrix3d& R_map_world = alignment.T_map_world.rotation;
  MapPoint point;
  point.enu_m = alignment.T_map_world * world_m;
  point.velocity_mps = R_map_world * velocity_mps;
  point.heading_deg = heading_deg(R_map_world * forward);
  point.sigma_m = horizontal_sigma_m(alignment, point.enu_m);
  return point;
}

MapTrajectory camera_trajectory(const recording::Run& run, const Alignment& alignment) {
  MapTrajectory camera{0, "camera", true, {}};
  for (std::size_t i = 0; i < run.camera.size(); ++i) {
    const recording::CameraRow& row = run.camera[i];
    MapPoint point = map_point(alignment, row.T_world_cam.translation, camera_velocity(run.camera, i),
                               row.T_world_cam.rotation.col(2));
    point.frame = row.frame;
    point.timestamp_ns = row.timestamp_ns;
    point.status = "tracked";
    camera.points.push_back(point);
  }
  return camera;
}

void add_row(const recording::ObjectRow& row, const Alignment& alignment, MapTrajectory& object) {
  // Where the world's y axis points down, the heading turns from x towards -z.
  const Eigen::Vector3d forward(std::cos(row.heading_rad), 0.0, -std::sin(row.heading_rad));
  MapPoint point = map_point(alignment, row.box.center_m, row.velocity_mps, forward);
  point.frame = row.frame;
  point.timestamp_ns = row.timestamp_ns;
  point.status = to_string(row.status);
  constexpr std::int64_t kMaxStep_frames = 2;
  point.is_after_gap = !object.points.empty() && row.frame - object.points.back().frame > kMaxStep_frames;
  object.points.push_back(point);
  object.kind = ClassName(row.class_id).view();
  object.moving = object.moving || row.moving;
}

}  // namespace

std::vector<geo::PathPose> camera_path(const recording::Run& run) {
  std::vector<geo::PathPose> path;
  for (const recording::CameraRow& row : run.camera) {
    path.push_back({row.timestamp_ns, row.T_world_cam});
  }
  return path;
}

std::vector<MapTrajectory> map_trajectories(const recording::Run& run, const Alignment& alignment) {
  std::map<std::uint32_t, MapTrajectory> objects;
  for (const recording::ObjectRow& row : run.objects) {
    if (row.status != BodyStatus::kLost) {
      MapTrajectory& object = objects[row.track_id];
      object.id = row.track_id;
      add_row(row, alignment, object);
    }
  }
  std::vector<MapTrajectory> trajectories{camera_trajectory(run, alignment)};
  for (auto& [id, object] : objects) {
    trajectories.push_back(std::move(object));
  }
  return trajectories;
}

}  // namespace kinetrace::map

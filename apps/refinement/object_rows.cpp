#include "object_rows.hpp"

#include <cmath>
#include <numbers>
#include <optional>

namespace kinetrace::batch {
namespace {

using recording::ObjectRow;

/// A box in the frame of its object.
struct CarriedBox {
  Box3 box;
  Box3Sigma sigma;
  Vector6d pose_variances = Vector6d::Zero();  ///< Of its frame's pose, in the world.
};

CarriedBox to_object(const ObjectRow& row) {
  const Se3 T_obj_world = row.T_world_obj.inverse();
  CarriedBox carried{row.box, row.box_sigma, row.variances};
  carried.box.center_m = T_obj_world * row.box.center_m;
  carried.box.down = T_obj_world.rotation * row.box.down;
  carried.box.yaw_rad = upright_yaw(carried.box.down, T_obj_world.rotation * row.box.rotation().col(0));
  return carried;
}

Box3 to_world(const CarriedBox& carried, const Se3& T_world_obj) {
  Box3 box = carried.box;
  box.center_m = T_world_obj * carried.box.center_m;
  box.down = T_world_obj.rotation * carried.box.down;
  box.yaw_rad = upright_yaw(box.down, T_world_obj.rotation * carried.box.rotation().col(0));
  return box;
}

/// Of a corner of the box, m^2.
double variance(const Box3Sigma& sigma, const Eigen::Vector3d& size_m) {
  const double reach_m = 0.5 * size_m.norm();
  const double turn_m = sigma.yaw_rad * reach_m;
  return sigma.center_m.squaredNorm() + 0.25 * sigma.size_m.squaredNorm() + turn_m * turn_m;
}

/// Increase of the variance by the uncertain rotation in between.
double carried_variance(const CarriedBox& carried, const ObjectRow& row) {
  const double turn_rad2 = row.variances.head<3>().sum() + carried.pose_variances.head<3>().sum();
  return variance(carried.sigma, carried.box.size_m) + turn_rad2 * carried.box.center_m.squaredNorm();
}

}  // namespace

void place_boxes(const ObjectHistory& history, RefinedObject& object) {
  std::optional<CarriedBox> best;
  double best_variance = 0.0;
  for (const auto& [row, seen] : history.rows) {
    if (seen.status != BodyStatus::kTracked) {
      continue;
    }
    const CarriedBox carried = to_object(seen);
    const double its_variance = carried_variance(carried, seen);
    if (!best || its_variance < best_variance) {
      best = carried;
      best_variance = its_variance;
    }
  }
  for (auto& [row, frame] : object.frames) {
    const ObjectRow& seen = history.rows.at(row);
    const CarriedBox own = to_object(seen);
    const bool is_carried = best && carried_variance(*best, seen) < carried_variance(own, seen);
    const CarriedBox& known = is_carried ? *best : own;
    frame.row.box = to_world(known, frame.row.T_world_obj);
    frame.row.box_sigma = known.sigma;
  }
}

void set_velocities(RefinedObject& object) {
  // As many frames before as after: constant rotation or acceleration then causes no error.
  constexpr std::size_t kReach = 3;
  const auto is_known = [&](std::size_t row) {
    const auto frame = object.frames.find(row);
    return frame != object.frames.end() && frame->second.row.status != BodyStatus::kLost;
  };
  for (auto& [at, frame] : object.frames) {
    ObjectRow& row = frame.row;
    std::size_t reach = 0;
    while (reach < kReach && at > reach && is_known(at - reach - 1) && is_known(at + reach + 1)) {
      ++reach;
    }
    const std::size_t before = at > 0 && reach == 0 && is_known(at - 1) ? at - 1 : at - reach;
    const std::size_t after = reach == 0 && before == at && is_known(at + 1) ? at + 1 : at + reach;
    if (before == after || row.status == BodyStatus::kLost) {
      continue;
    }
    const Eigen::Vector3d center_obj_m = row.T_world_obj.inverse() * row.box.center_m;
    const ObjectRow& from = object.frames.at(before).row;
    const ObjectRow& to = object.frames.at(after).row;
    const Eigen::Vector3d way_m = to.T_world_obj * center_obj_m - from.T_world_obj * center_obj_m;
    const double time_s = 1e-9 * static_cast<double>(to.timestamp_ns - from.timestamp_ns);
    const bool has_velocity = row.moving || row.status == BodyStatus::kTracked;
    row.velocity_mps = has_velocity ? Eigen::Vector3d(way_m / time_s) : Eigen::Vector3d::Zero();
    // Without motion, the heading is the box's.
    const Eigen::Vector3d along = row.moving ? row.velocity_mps : Eigen::Vector3d(row.box.rotation().col(0));
    row.heading_rad = std::atan2(-along.z(), along.x());
  }
}

}  // namespace kinetrace::batch

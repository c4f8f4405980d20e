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
  Vector6d pose_variances = Vector6d::Zero();  ///< Of the pose it was seen from, in the world.
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

/// By which it grows where the object may have turned in between.
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
    const CarriedBox own = to_object(history.rows.at(row));
    const bool is_carried = best && carried_variance(*best, frame.row) < carried_variance(own, frame.row);
    const CarriedBox& known = is_carried ? *best : own;
    frame.row.box = to_world(known, frame.row.T_world_obj);
    frame.row.box_sigma = known.sigma;
  }
}

void set_velocities(RefinedObject& object) {
  for (auto frame = object.frames.begin(); frame != object.frames.end(); ++frame) {
    const auto is_beside = [&](auto other, std::size_t row) {
      return other != object.frames.end() && other->first == row && other->second.row.status != BodyStatus::kLost;
    };
    auto before = frame == object.frames.begin() ? object.frames.end() : std::prev(frame);
    auto after = std::next(frame);
    before = is_beside(before, frame->first - 1) ? before : frame;
    after = is_beside(after, frame->first + 1) ? after : frame;
    ObjectRow& row = frame->second.row;
    if (before == after || row.status == BodyStatus::kLost) {
      continue;
    }
    const Se3& T_world_obj = row.T_world_obj;
    const Eigen::Vector3d center_obj_m = T_world_obj.inverse() * row.box.center_m;
    const Eigen::Vector3d way_m =
        after->second.row.T_world_obj * center_obj_m - before->second.row.T_world_obj * center_obj_m;
    const double time_s = 1e-9 * static_cast<double>(after->second.row.timestamp_ns - before->second.row.timestamp_ns);
    const bool has_velocity = row.moving || row.status == BodyStatus::kTracked;
    row.velocity_mps = has_velocity ? Eigen::Vector3d(way_m / time_s) : Eigen::Vector3d::Zero();
    // Of a motion towards nowhere, the box tells the direction.
    const Eigen::Vector3d along = row.moving ? row.velocity_mps : Eigen::Vector3d(row.box.rotation().col(0));
    row.heading_rad = std::atan2(-along.z(), along.x());
  }
}

}  // namespace kinetrace::batch

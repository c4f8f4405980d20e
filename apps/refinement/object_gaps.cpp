#include "object_gaps.hpp"

#include <algorithm>

#include "gap_path.hpp"

namespace kinetrace::batch {
namespace {

using recording::ObjectRow;

constexpr double kMaxGap_s = 5.0;
// The first velocity is not extrapolated further.
constexpr double kMaxBirth_s = 1.0;

/// `known` moved to another frame, with its box's centre at `center_m`.
ObjectRow moved_row(const ObjectRow& known, const recording::CameraRow& camera, const Eigen::Vector3d& center_m) {
  ObjectRow row = known;
  row.frame = camera.frame;
  row.timestamp_ns = camera.timestamp_ns;
  row.status = BodyStatus::kPropagated;
  row.inliers = 0;
  row.pixel_height = 0;
  row.mask_px = {};
  row.T_world_obj.translation += center_m - known.box.center_m;
  row.box.center_m = center_m;
  return row;
}

/// The box's centre in the object's frame.
Eigen::Vector3d center_in_object_m(const ObjectRow& row) {
  return row.T_world_obj.inverse() * row.box.center_m;
}

/// Of one point of the object at both ends: the boxes there may differ.
GapPath path_between(const ObjectRow& from, const ObjectRow& to) {
  GapPath path = GapPath::between(from, to);
  path.to_m = to.T_world_obj * center_in_object_m(from);
  return path;
}

void fill_between(const recording::Run& run, std::span<const Se3> T_world_cam, const GapPath& path, std::size_t before,
                  std::size_t after, RefinedObject& object) {
  const ObjectRow from = object.frames.at(before).row;
  const ObjectRow to = object.frames.at(after).row;
  const Eigen::Vector3d point_obj_m = center_in_object_m(from);
  for (std::size_t at = before + 1; at < after; ++at) {
    const recording::CameraRow& camera = run.camera[at];
    const double s = 1e-9 * static_cast<double>(camera.timestamp_ns - from.timestamp_ns) / path.time_s;
    Se3 T_world_obj = interpolate(from.T_world_obj, to.T_world_obj, s);
    T_world_obj.translation = path.position_m(s) - T_world_obj.rotation * point_obj_m;
    const Eigen::Vector3d center_obj_m = (1.0 - s) * point_obj_m + s * center_in_object_m(to);
    RefinedObjectFrame& filled = object.frames[at];
    ObjectRow row = moved_row(s < 0.5 ? from : to, camera, T_world_obj * center_obj_m);
    row.T_world_obj = T_world_obj;
    row.velocity_mps = path.velocity_mps(s);
    row.pixel_height = filled.row.pixel_height;
    row.mask_px = filled.row.mask_px;
    filled = {row, row.T_world_obj.inverse() * T_world_cam[at]};
  }
}

}  // namespace

void fill_gaps(const recording::Run& run, std::span<const Se3> T_world_cam, RefinedObject& object) {
  std::vector<std::size_t> known;
  for (const auto& [row, frame] : object.frames) {
    if (frame.row.status != BodyStatus::kLost) {
      known.push_back(row);
    }
  }
  for (std::size_t i = 1; i < known.size(); ++i) {
    const GapPath path = path_between(object.frames.at(known[i - 1]).row, object.frames.at(known[i]).row);
    if (known[i] - known[i - 1] > 1 && path.is_possible(kMaxGap_s)) {
      fill_between(run, T_world_cam, path, known[i - 1], known[i], object);
    }
  }
}

void fill_birth(const recording::Run& run, std::span<const Se3> T_world_cam,
                const std::map<std::size_t, PixelBox>& masks_px, RefinedObject& object) {
  if (object.frames.empty() || object.frames.begin()->second.row.status == BodyStatus::kLost) {
    return;
  }
  const std::size_t first_row = object.frames.begin()->first;
  const ObjectRow first = object.frames.begin()->second.row;
  for (std::size_t at = first_row; at-- > 0;) {
    const auto mask = masks_px.find(at);
    const double before_s = 1e-9 * static_cast<double>(first.timestamp_ns - run.camera[at].timestamp_ns);
    if (mask == masks_px.end() || before_s > kMaxBirth_s) {
      return;
    }
    const Eigen::Vector3d center_m = first.box.center_m - before_s * first.velocity_mps;
    const Eigen::Vector3d center_cam_m = T_world_cam[at].inverse() * center_m;
    const Eigen::Vector3d px = run.rectified.project(center_cam_m);
    const PixelBox& box = mask->second;
    if (center_cam_m.z() <= 0.0 || px.x() < box.x0 || px.x() > box.x1 || px.y() < box.y0 || px.y() > box.y1) {
      return;
    }
    ObjectRow row = moved_row(first, run.camera[at], center_m);
    row.mask_px = box;
    row.pixel_height = box.height();
    object.frames[at] = {row, row.T_world_obj.inverse() * T_world_cam[at]};
  }
}

}  // namespace kinetrace::batch

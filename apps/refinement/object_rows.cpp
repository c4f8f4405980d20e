#include "object_rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <vector>

namespace kinetrace::batch {
namespace {

using recording::ObjectRow;

// Of boxes, spread evenly over the track: their distances to each other take time by the square of their number.
constexpr std::size_t kMaxCompared = 100;
constexpr double kMinSigma_m = 1e-3;

/// A box in the frame of its object.
struct CarriedBox {
  Box3 box;
  Box3Sigma sigma;
  double sigma_m = 0.0;  ///< Of a corner.
};

Box3 moved(const Box3& box, const Se3& to) {
  Box3 result = box;
  result.center_m = to * box.center_m;
  result.down = to.rotation * box.down;
  result.yaw_rad = upright_yaw(result.down, to.rotation * box.rotation().col(0));
  return result;
}

double corner_variance(const Box3Sigma& sigma, const Eigen::Vector3d& size_m) {
  const double reach_m = 0.5 * size_m.norm();
  const double turn_m = sigma.yaw_rad * reach_m;
  return sigma.center_m.squaredNorm() + 0.25 * sigma.size_m.squaredNorm() + turn_m * turn_m;
}

/// The run saw the box from the camera: with the refined pose relative to that, it is in the object's refined frame.
CarriedBox to_object(const ObjectRow& seen, const Se3& T_world_cam, const RefinedObjectFrame& refined) {
  const Box3 box = moved(seen.box, refined.T_obj_cam * T_world_cam.inverse());
  const double turn_rad2 = refined.row.variances.head<3>().sum();
  return {box, seen.box_sigma,
          std::sqrt(corner_variance(seen.box_sigma, box.size_m) + turn_rad2 * box.center_m.squaredNorm())};
}

/// Mean distance of corresponding corners; a box does not say which end is the front.
double distance_m(const Box3& a, const Box3& b) {
  Box3 turned = b;
  turned.yaw_rad += std::numbers::pi;
  const auto corners_a = a.corners();
  const auto to = [&](const Box3& other) {
    const auto corners = other.corners();
    double sum_m = 0.0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      sum_m += (corners_a[i] - corners[i]).norm();
    }
    return sum_m / static_cast<double>(corners.size());
  };
  return std::min(to(b), to(turned));
}

/// The medoid, distances in sigmas: a few frames of a track may be of another object, with a box that is no less
/// certain.
const CarriedBox* most_central(const std::vector<CarriedBox>& boxes) {
  const CarriedBox* best = nullptr;
  double best_sum = std::numeric_limits<double>::infinity();
  for (const CarriedBox& candidate : boxes) {
    double sum = 0.0;
    for (const CarriedBox& other : boxes) {
      sum += distance_m(candidate.box, other.box) / std::max(other.sigma_m, kMinSigma_m);
    }
    if (sum < best_sum) {
      best_sum = sum;
      best = &candidate;
    }
  }
  return best;
}

}  // namespace

void place_boxes(const recording::Run& run, const ObjectHistory& history, RefinedObject& object) {
  const auto carried = [&](std::size_t row) {
    return to_object(history.rows.at(row), run.camera[row].T_world_cam, object.frames.at(row));
  };
  std::vector<std::size_t> tracked;
  for (const auto& [row, seen] : history.rows) {
    if (seen.status == BodyStatus::kTracked) {
      tracked.push_back(row);
    }
  }
  std::vector<CarriedBox> boxes;
  const std::size_t step = tracked.size() / kMaxCompared + 1;
  for (std::size_t i = 0; i < tracked.size(); i += step) {
    boxes.push_back(carried(tracked[i]));
  }
  const CarriedBox* central = most_central(boxes);
  for (auto& [row, frame] : object.frames) {
    const CarriedBox own = carried(row);
    const bool is_carried =
        central != nullptr && (history.rows.at(row).status == BodyStatus::kTracked || central->sigma_m < own.sigma_m);
    const CarriedBox& known = is_carried ? *central : own;
    frame.row.box = moved(known.box, frame.row.T_world_obj);
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

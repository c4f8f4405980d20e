#include "packed_window.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "window_check.hpp"

namespace kinetrace::refinement {
namespace {

// A farther point is moved here along its ray, which keeps its projections, and single precision finite.
constexpr double kMaxDistance_m = 1e8;

std::size_t groups_of(std::size_t points) {
  return (points + kLanes - 1) / kLanes;
}

Eigen::Vector3d within_reach(const Eigen::Vector3d& point) {
  const double distance_m = point.norm();
  return distance_m > kMaxDistance_m ? Eigen::Vector3d(point * (kMaxDistance_m / distance_m)) : point;
}

void set_lane(PointLanes& points, std::size_t lane, const Eigen::Vector3d& position) {
  points.x[lane] = static_cast<float>(position.x());
  points.y[lane] = static_cast<float>(position.y());
  points.z[lane] = static_cast<float>(position.z());
}

void set_lane(ObservationLanes& lanes, std::size_t lane, const BundleObservation& observation) {
  const float weight = observation.inverse_sigma_px * observation.inverse_sigma_px;
  const bool has_right = !std::isnan(observation.u_right_px);
  lanes.u_left_px[lane] = observation.u_left_px;
  lanes.v_px[lane] = observation.v_px;
  lanes.u_right_px[lane] = has_right ? observation.u_right_px : 0.F;
  lanes.left_weight[lane] = weight;
  lanes.right_weight[lane] = has_right ? weight : 0.F;
}

}  // namespace

PackedWindow::PackedWindow(Arena& arena, int max_frames, int max_points) {
  const auto frame_capacity = static_cast<std::size_t>(max_frames);
  const auto point_capacity = static_cast<std::size_t>(max_points);
  const std::size_t group_capacity = groups_of(point_capacity);
  free_index = arena.take<int>(frame_capacity);
  T_cam_anchor = arena.take<Se3>(frame_capacity);
  order = arena.take<std::uint64_t>(point_capacity);
  group = arena.take<PointGroup>(group_capacity);
  observations = arena.take<ObservationLanes>(group_capacity * frame_capacity);
  initial = arena.take<PointLanes>(group_capacity);
  current = arena.take<PointLanes>(group_capacity);
}

int PackedWindow::count_points(const BundleWindow& window) {
  const std::uint32_t mask = frame_mask(window.T_body_cam.size());
  return static_cast<int>(std::count_if(window.points.begin(), window.points.end(),
                                        [mask](const BundlePoint& point) { return (point.frames & mask) != 0; }));
}

void PackedWindow::pack(const BundleWindow& window) {
  frames = static_cast<int>(window.T_body_cam.size());
  const std::uint32_t mask = frame_mask(window.T_body_cam.size());
  T_body_anchor = window.T_body_cam[static_cast<std::size_t>(std::countr_zero(window.fixed_frames & mask))];
  const Se3 T_anchor_body = T_body_anchor.inverse();

  free_frames = 0;
  for (std::size_t k = 0; k < window.T_body_cam.size(); ++k) {
    const bool fixed = (window.fixed_frames >> k & 1U) != 0;
    free_index[k] = fixed ? -1 : free_frames++;
    T_cam_anchor[k] = (T_anchor_body * window.T_body_cam[k]).inverse();
  }

  // Points of the same frames are grouped, so that few lanes idle.
  points = 0;
  for (std::size_t p = 0; p < window.points.size(); ++p) {
    const std::uint64_t seen = window.points[p].frames & mask;
    if (seen != 0) {
      order[static_cast<std::size_t>(points++)] = seen << 32U | p;
    }
  }
  const auto count = static_cast<std::size_t>(points);
  std::sort(order.begin(), order.begin() + points);

  groups = static_cast<int>(groups_of(count));
  std::uint32_t next_observation = 0;
  for (std::size_t first = 0, g = 0; first < count; first += kLanes, ++g) {
    const std::size_t lanes = std::min<std::size_t>(kLanes, count - first);
    std::uint32_t seen = 0;
    initial[g] = PointLanes{};
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      seen |= static_cast<std::uint32_t>(order[first + lane] >> 32U);
      const auto point = static_cast<std::uint32_t>(order[first + lane]);
      set_lane(initial[g], lane, within_reach(T_anchor_body * window.points[point].position_m));
    }
    current[g] = initial[g];
    group[g] = {seen, next_observation};
    for (; seen != 0; seen &= seen - 1) {
      const auto frame = static_cast<std::size_t>(std::countr_zero(seen));
      ObservationLanes& row = observations[next_observation++];
      row = ObservationLanes{};
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        const auto point = static_cast<std::uint32_t>(order[first + lane]);
        if ((window.points[point].frames >> frame & 1U) != 0) {
          set_lane(row, lane, window.observation(point, frame));
        }
      }
    }
  }
}

void PackedWindow::unpack(BundleWindow& window) const {
  for (std::size_t k = 0; k < window.T_body_cam.size(); ++k) {
    if (free_index[k] >= 0) {
      window.T_body_cam[k] = (T_body_anchor * T_cam_anchor[k].inverse()).orthonormalised();
    }
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(points); ++i) {
    const std::size_t lane = i % kLanes;
    const PointLanes& from = initial[i / kLanes];
    const PointLanes& to = current[i / kLanes];
    const Eigen::Vector3d moved(static_cast<double>(to.x[lane]) - static_cast<double>(from.x[lane]),
                                static_cast<double>(to.y[lane]) - static_cast<double>(from.y[lane]),
                                static_cast<double>(to.z[lane]) - static_cast<double>(from.z[lane]));
    window.points[static_cast<std::uint32_t>(order[i])].position_m += T_body_anchor.rotation * moved;
  }
}

}  // namespace kinetrace::refinement

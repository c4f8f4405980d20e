#include "native/trajectory_pieces.hpp"

#include <algorithm>

#include "native/native_values.hpp"
#include "transport/sequences.hpp"

namespace kinetrace::publishing {
namespace {

kinetrace_TrajectoryPose trajectory_pose(const TrajectoryEvent& event) noexcept {
  kinetrace_TrajectoryPose pose{};
  pose.frame = event.frame_index;
  pose.timestamp_ns = event.timestamp_ns;
  pose.position = to_wire(event.T_world_obj.translation);
  const Eigen::Quaterniond q = event.T_world_obj.quaternion();
  copy_floats(q.coeffs(), pose.orientation_xyzw);
  copy_floats(event.velocity_mps, pose.velocity_mps);
  pose.status = to_wire(event.status);
  return pose;
}

}  // namespace

// Twice the objects: poses of ended tracks become final while new tracks are in their slots.
TrajectoryPieces::TrajectoryPieces(const PublishConfig& config, Arena& arena)
    : open_(arena.take<Open>(2 * static_cast<std::size_t>(config.max_objects))),
      poses_per_piece_(items_per_piece(config.piece_bytes, sizeof(kinetrace_TrajectoryPose), kMaxPoses)) {}

TrajectoryPieces::Open* TrajectoryPieces::find(std::uint32_t track_id) noexcept {
  const auto found =
      std::find_if(open_.begin(), open_.end(), [track_id](const Open& open) { return open.track_id == track_id; });
  return found == open_.end() ? nullptr : &*found;
}

TrajectoryPieces::Open& TrajectoryPieces::least_recently_updated() noexcept {
  return *std::min_element(open_.begin(), open_.end(),
                           [](const Open& a, const Open& b) { return a.last_update < b.last_update; });
}

TrajectoryPart TrajectoryPieces::take_piece(Open& open) noexcept {
  const TrajectoryPart part{open.track_id, open.class_id, false, open.first_pose,
                            std::span(open.poses).first(open.count)};
  open.first_pose += static_cast<std::uint32_t>(open.count);
  open.count = 0;
  return part;
}

void TrajectoryPieces::begin(Open& open, const TrajectoryEvent& event) noexcept {
  open.track_id = event.track_id;
  open.class_id = event.class_id;
  open.first_pose = 0;
}

void TrajectoryPieces::append(Open& open, const TrajectoryEvent& event) noexcept {
  open.last_update = ++events_;
  open.poses[open.count++] = trajectory_pose(event);
}

}  // namespace kinetrace::publishing

#include "fixed_lag_results.hpp"

namespace kinetrace::pipeline {
namespace {

// Final frames that are kept because they constrain the motion into the window.
constexpr std::size_t kFinalFramesBuffered = 2;

std::size_t ring_frames(const PipelineConfig& config) {
  return static_cast<std::size_t>(config.background.window_frames) + 1 + kFinalFramesBuffered;
}

/// The track of a buffered object has not ended since.
bool is_of(const BufferedObject& entry, const ObjectState& object) {
  return object.alive() && object.track().id == entry.result.track_id;
}

}  // namespace

FixedLagResults::FixedLagResults(const PipelineConfig& config, Arena& arena)
    : window_frames_(static_cast<std::size_t>(config.background.window_frames)),
      paths_(config.trajectory, ring_frames(config), arena),
      ring_(arena, ring_frames(config), static_cast<std::size_t>(config.tracking.max_objects)) {}

void FixedLagResults::push(const RectifiedPair& pair, std::span<const ObjectState> objects) {
  if (ring_.full()) {
    ring_.pop_oldest();
  }
  BufferedFrame& kept = ring_.push();
  ++pending_;
  kept.frame_index = pair.frame_index;
  kept.timestamp_ns = pair.timestamp_ns;
  for (std::size_t slot = 0; slot < objects.size(); ++slot) {
    const ObjectState& object = objects[slot];
    if (object.alive() && object.status() != BodyStatus::kInitializing && !object.is_out_of_view()) {
      BufferedObject& entry = kept.objects[kept.object_count++];
      entry = BufferedObject{.result = {}, .slot = static_cast<std::uint8_t>(slot), .confirmed = false};
      object.report(entry.result);
      entry.change = object.frame_change();
      entry.drift_covariance = object.drift_covariance();
    }
  }
}

void FixedLagResults::revise(const CameraTracker& camera, const std::optional<Eigen::Vector3d>& vertical,
                             std::span<ObjectState> objects) {
  revise_poses(camera, objects);
  smooth_paths(vertical, objects);
  describe_motions(objects);
}

void FixedLagResults::revise_poses(const CameraTracker& camera, std::span<ObjectState> objects) {
  for (std::size_t age = 0; age < pending_; ++age) {
    BufferedFrame& kept = ring_.frame(age);
    kept.camera = camera.result(age);
    const CameraState then = camera.state(age);
    for (BufferedObject& entry : kept.objects.first(kept.object_count)) {
      ObjectState& object = objects[entry.slot];
      if (is_of(entry, object)) {
        object.revise(age, then, entry.result);
        entry.confirmed = object.confirmed();
      } else {
        // Its track has ended: only the camera is still being refined.
        entry.result.T_world_obj = then.T_world_cam * entry.result.T_obj_cam.inverse();
      }
    }
  }
}

void FixedLagResults::smooth_paths(const std::optional<Eigen::Vector3d>& vertical, std::span<ObjectState> objects) {
  for (std::size_t age = 0; age < pending_; ++age) {
    BufferedFrame& kept = ring_.frame(age);
    for (const BufferedObject& entry : kept.objects.first(kept.object_count)) {
      const std::uint32_t track_id = entry.result.track_id;
      if (!TrajectoryBuffer::ends_at(ring_, track_id, age)) {
        continue;
      }
      ObjectState& object = objects[entry.slot];
      const PathObject of_path = object.track().id == track_id
                                     ? PathObject{{object.at_rest(), vertical}, object.reconstructed()}
                                     : PathObject{.prior = {.vertical = vertical}};
      if (const std::optional<PathEnd> end = paths_.smooth(ring_, pending_, track_id, age, of_path)) {
        object.reinitialise_filter(end->T_world_obj, end->velocity);
      }
    }
  }
}

void FixedLagResults::describe_motions(std::span<const ObjectState> objects) {
  for (std::size_t age = 0; age < pending_; ++age) {
    BufferedFrame& kept = ring_.frame(age);
    for (BufferedObject& entry : kept.objects.first(kept.object_count)) {
      const ObjectState& object = objects[entry.slot];
      if (is_of(entry, object)) {
        object.describe_motion(age, entry.result);
      }
    }
  }
}

}  // namespace kinetrace::pipeline

#include "frame_result_builder.hpp"

namespace kinetrace::pipeline {
namespace {

/// A perturbation of the object's frame turns it about its origin.
Matrix6d in_world_axes(const Matrix6d& covariance, const Eigen::Matrix3d& R_world_obj) {
  const Matrix6d axes = adjoint(Se3{R_world_obj, Eigen::Vector3d::Zero()});
  return axes * covariance * axes.transpose();
}

/// `objects` holds the confirmed ones of the frame afterwards.
FrameEstimate confirmed_part(const BufferedFrame& frame, std::span<ObjectResult> objects) {
  std::size_t count = 0;
  for (const BufferedObject& entry : frame.objects.first(frame.object_count)) {
    if (entry.confirmed) {
      objects[count] = entry.result;
      objects[count].covariance += in_world_axes(entry.drift_covariance, entry.result.T_world_obj.rotation);
      ++count;
    }
  }
  return {frame.frame_index, frame.timestamp_ns, frame.camera, objects.first(count)};
}

BodyGeometry geometry_of(std::uint32_t track_id, BodyStatus status, const BodyEstimate& estimate) {
  return {track_id, status, estimate.is_keyframe, estimate.points, estimate.frame_observations, estimate.retired};
}

}  // namespace

FrameResultBuilder::FrameResultBuilder(const PipelineConfig& config, Arena& arena) {
  const auto objects = static_cast<std::size_t>(config.tracking.max_objects);
  newest_objects_ = arena.take<ObjectResult>(objects);
  finalised_objects_ = arena.take<ObjectResult>(objects);
  bodies_ = arena.take<BodyGeometry>(objects + 1);
  tracks_ = arena.take<Track>(objects);
}

void FrameResultBuilder::set_newest(const BufferedFrame& frame) {
  result_.newest = confirmed_part(frame, newest_objects_);
}

void FrameResultBuilder::set_finalised(const BufferedFrame* frame) {
  result_.has_finalised = frame != nullptr;
  if (frame != nullptr) {
    result_.finalised = confirmed_part(*frame, finalised_objects_);
  }
}

void FrameResultBuilder::set_bodies(const sfm::BodyReconstruction& background, std::span<const ObjectState> objects) {
  bodies_[0] = geometry_of(0, background.estimate().status, background.estimate());
  std::size_t count = 1;
  for (const ObjectState& object : objects) {
    if (object.in_use() && object.confirmed()) {
      bodies_[count++] = geometry_of(object.track().id, object.status(), object.body().estimate());
    }
  }
  result_.bodies = bodies_.first(count);
}

void FrameResultBuilder::set_tracks(std::span<const Track> tracks, std::span<const ObjectState> objects) {
  const auto end = std::transform(tracks.begin(), tracks.end(), tracks_.begin(), [objects](Track track) {
    track.state = objects[track.slot].confirmed() ? track.state : TrackState::kTentative;
    return track;
  });
  result_.tracks = {tracks_.begin(), end};
}

void FrameResultBuilder::set_frame(const RectifiedPair& pair, const TrackFrame& tracks, const FrameCounters& counters) {
  result_.pair = pair;
  result_.left_labels = tracks.left_labels;
  result_.right_labels = tracks.right_labels;
  result_.counters = counters;
}

void FrameResultBuilder::clear_frame() noexcept {
  result_.tracks = {};
  result_.pair.left = {};
  result_.pair.right = {};
  result_.left_labels = {};
  result_.right_labels = {};
}

}  // namespace kinetrace::pipeline

#include "object_set.hpp"

#include <algorithm>
#include <utility>

namespace kinetrace::pipeline {

Result<ObjectSet> ObjectSet::create(const PipelineConfig& config, const StereoGeometry& geometry, Arena& arena) {
  std::vector<ObjectState> slots;
  slots.reserve(static_cast<std::size_t>(config.tracking.max_objects));
  for (int i = 0; i < config.tracking.max_objects; ++i) {
    auto object = ObjectState::create(config, geometry, arena);
    if (!object) {
      return Unexpected(object.error());
    }
    slots.push_back(std::move(*object));
  }
  return ObjectSet(std::move(slots));
}

std::size_t ObjectSet::required_bytes(const PipelineConfig& config) {
  return ObjectState::required_bytes(config) * static_cast<std::size_t>(config.tracking.max_objects);
}

void ObjectSet::prediction(std::int64_t timestamp_ns, const Se3& T_world_cam,
                           std::span<tracking::ObjectPrediction> by_slot) const {
  for (std::size_t slot = 0; slot < slots_.size(); ++slot) {
    by_slot[slot] =
        slots_[slot].alive() ? slots_[slot].prediction(timestamp_ns, T_world_cam) : tracking::ObjectPrediction{};
  }
}

void ObjectSet::take_tracks(const TrackFrame& tracks) {
  for (const Track& track : tracks.tracks) {
    if (track.id > newest_track_id_) {
      newest_track_id_ = track.id;
      ++counters_.born;
    }
    const ObjectState& object = slots_[track.slot];
    const bool was_confirmed = object.track().id == track.id && object.confirmed();
    counters_.confirmed += track.state == TrackState::kConfirmed && !was_confirmed ? 1U : 0U;
  }
  for (const Track& track : tracks.ended) {
    ++counters_.ended;
    slots_[track.slot].end();
  }
}

std::optional<ReidentifiedObject> ObjectSet::reidentify(const Track& track, const FeatureFrame& frame, LabelView labels,
                                                        const CameraState& camera) {
  ObjectState& candidate = slots_[track.slot];
  if (candidate.track().id != track.id) {
    candidate.begin(track);
  }
  if (candidate.placed()) {
    return std::nullopt;
  }
  const std::optional<Eigen::Vector3d> position_m = candidate.observed_position(frame, labels, camera);
  ObjectState* const lost = find_lost(candidate, track, position_m, camera);
  if (lost == nullptr) {
    return std::nullopt;
  }
  candidate.continue_from(*lost, position_m);
  lost->transfer_identity();
  return ReidentifiedObject{lost->track().slot, lost->track().id};
}

ObjectState* ObjectSet::find_lost(const ObjectState& candidate, const Track& track,
                                  const std::optional<Eigen::Vector3d>& position_m, const CameraState& camera) {
  ObjectState* nearest = nullptr;
  double least = 1.0;
  for (ObjectState& lost : slots_) {
    if (&lost == &candidate) {
      continue;
    }
    const std::optional<double> part =
        lost.placed() && position_m ? lost.position_gate(*position_m, track, camera) : lost.bearing_gate(track, camera);
    if (part && *part <= least) {
      nearest = &lost;
      least = *part;
    }
  }
  return nearest;
}

bool ObjectSet::may_be_lost_object(const Track& track, const CameraState& camera) const {
  return !slots_[track.slot].placed() && std::any_of(slots_.begin(), slots_.end(), [&](const ObjectState& lost) {
    return lost.track().slot != track.slot && lost.may_come_back_as(track, camera);
  });
}

bool ObjectSet::observe(const Track& track, const FeatureFrame& frame, LabelView labels, const CameraState& camera,
                        const features::FeatureFrontEnd& front_end) {
  ObjectState& object = slots_[track.slot];
  object.observe(track, frame, labels, camera, front_end);
  return !object.identity_switched();
}

std::size_t ObjectSet::list_windows(std::span<BodyRefinement> windows) {
  std::size_t count = 0;
  for (ObjectState& object : slots_) {
    if (object.alive() && object.reconstructing()) {
      windows[count++] = {&object.body(), {}};
    }
  }
  return count;
}

void ObjectSet::conclude(std::span<const BodyRefinement> windows, const CameraState& camera,
                         const trajectory::Ground& ground) {
  std::size_t count = 0;
  for (ObjectState& object : slots_) {
    if (object.alive()) {
      object.conclude(object.reconstructing() ? windows[count++].summary : BundleSummary{}, camera, ground);
    }
  }
}

void ObjectSet::remember(const FeatureFrame& frame, const features::FeatureFrontEnd& front_end) {
  for (ObjectState& object : slots_) {
    if (object.alive()) {
      object.remember(frame, front_end);
    }
  }
}

void ObjectSet::release(std::span<const Track> ended) {
  for (ObjectState& object : slots_) {
    if (object.handed_over()) {
      object.release();
    }
  }
  for (const Track& track : ended) {
    slots_[track.slot].release();
  }
}

void ObjectSet::end() {
  for (ObjectState& object : slots_) {
    if (object.in_use()) {
      object.end();
    }
  }
}

void ObjectSet::remeasure(const RigChange& change) noexcept {
  for (ObjectState& object : slots_) {
    if (object.in_use()) {
      object.body().remeasure(change);
    }
  }
}

void ObjectSet::restart_paths() noexcept {
  for (ObjectState& object : slots_) {
    if (object.in_use()) {
      object.restart_path();
    }
  }
}

}  // namespace kinetrace::pipeline

#include "object_set.hpp"

#include <algorithm>
#include <optional>
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
  return ObjectSet(std::move(slots), config.objects.stereo_only_min_features, arena);
}

std::size_t ObjectSet::required_bytes(const PipelineConfig& config) {
  const auto objects = static_cast<std::size_t>(config.tracking.max_objects);
  return ObjectState::required_bytes(config) * objects +
         measure_bytes([&](Arena& arena) { FixedVector<ReidentifiedObject>(arena, objects); });
}

void ObjectSet::predict(std::int64_t timestamp_ns, const Se3& T_world_cam,
                        std::span<tracking::ObjectPrediction> by_slot) const {
  for (std::size_t slot = 0; slot < slots_.size(); ++slot) {
    by_slot[slot] =
        slots_[slot].alive() ? slots_[slot].prediction(timestamp_ns, T_world_cam) : tracking::ObjectPrediction{};
  }
}

void ObjectSet::take_tracks(const TrackFrame& tracks) {
  for (const Track& track : tracks.tracks) {
    if (slots_[track.slot].track().id != track.id) {
      slots_[track.slot].begin(track);
    }
  }
  for (const Track& track : tracks.ended) {
    slots_[track.slot].end();
  }
}

void ObjectSet::split(const Track& detected, const Track& dormant) {
  std::swap(slots_[detected.slot], slots_[dormant.slot]);
  slots_[dormant.slot].set_dormant(dormant);
  slots_[detected.slot].begin(detected);
}

std::span<const ReidentifiedObject> ObjectSet::reidentify(std::span<const Track> tracks, const FeatureFrame& frame,
                                                          LabelView labels, const CameraState& camera) {
  const auto count = static_cast<int>(slots_.size());
  affinity_.resize(count, count);
  std::uint64_t detected = 0;  // By slot: an object detected in this frame is not lost.
  for (const Track& track : tracks) {
    detected |= std::uint64_t{track.missed_frames == 0} << track.slot;
  }
  for (const Track& track : tracks) {
    if (!is_detected_without_position(track)) {
      continue;
    }
    const StereoObservation observation = slots_[track.slot].observe_stereo(frame, labels, camera);
    const bool is_position_measured = camera.valid && observation.features >= min_features_;
    for (int slot = 0; slot < count; ++slot) {
      const ObjectState& lost = slots_[static_cast<std::size_t>(slot)];
      const bool was_split_from_track = lost.track_before().slot == track.slot;
      if (((detected >> slot) & 1U) != 0 || was_split_from_track) {
        continue;
      }
      const std::optional<double> evidence = lost.has_position() && is_position_measured
                                                 ? lost.position_evidence(observation, track, camera)
                                                 : lost.bearing_evidence(track, camera);
      affinity_(slot, track.slot) = std::max(evidence.value_or(0.0), 0.0);
    }
  }
  reidentified_.clear();
  const tracking::Assignment match = tracking::maximum_weight_assignment(affinity_);
  for (std::size_t slot = 0; slot < slots_.size(); ++slot) {
    if (match[slot] >= 0) {
      ObjectState& lost = slots_[slot];
      ObjectState& found = slots_[static_cast<std::size_t>(match[slot])];
      found.continue_from(lost);
      lost.end();
      (void)reidentified_.push_back(
          {lost.track().slot, found.track().slot, lost.track().id});  // as many places as slots
    }
  }
  return reidentified_.span();
}

bool ObjectSet::observe(const Track& track, const FeatureFrame& frame, LabelView labels, const CameraState& camera) {
  ObjectState& object = slots_[track.slot];
  object.observe(track, frame, labels, camera);
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

void ObjectSet::release() {
  for (ObjectState& object : slots_) {
    if (object.in_use() && !object.alive()) {
      object.release();
    }
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

#include "object_set.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace kinetrace::pipeline {
namespace {

constexpr double kTieBreak = 1e-3;  // An object at the end of its reach still weighs more than none.

}  // namespace

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
  return ObjectSet(std::move(slots), arena);
}

std::size_t ObjectSet::required_bytes(const PipelineConfig& config) {
  const auto objects = static_cast<std::size_t>(config.tracking.max_objects);
  return ObjectState::required_bytes(config) * objects +
         measure_bytes([&](Arena& arena) { FixedVector<ReidentifiedObject>(arena, objects); });
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
    ObjectState& object = slots_[track.slot];
    const bool was_confirmed = object.track().id == track.id && object.confirmed();
    if (object.track().id != track.id) {
      object.begin(track);
    }
    counters_.confirmed += track.state == TrackState::kConfirmed && !was_confirmed ? 1U : 0U;
  }
  for (const Track& track : tracks.ended) {
    ++counters_.ended;
    slots_[track.slot].end();
  }
}

void ObjectSet::split(const Track& seen, const Track& waiting) {
  std::swap(slots_[seen.slot], slots_[waiting.slot]);
  slots_[waiting.slot].wait_as(waiting);
  slots_[seen.slot].begin(seen);
}

std::span<const ReidentifiedObject> ObjectSet::reidentify(std::span<const Track> tracks, const FeatureFrame& frame,
                                                          LabelView labels, const CameraState& camera) {
  const auto count = static_cast<int>(slots_.size());
  affinity_.resize(count, count);
  for (const Track& track : tracks) {
    if (!is_unplaced(track)) {
      continue;
    }
    const std::optional<Eigen::Vector3d> position_m = slots_[track.slot].observed_position(frame, labels, camera);
    for (int slot = 0; slot < count; ++slot) {
      const ObjectState& lost = slots_[static_cast<std::size_t>(slot)];
      const bool by_position = lost.placed() && position_m;
      const std::optional<double> part =
          by_position ? lost.position_gate(*position_m, track, camera) : lost.bearing_gate(track, camera);
      if (part && slot != track.slot) {
        affinity_(slot, track.slot) = 1.0 + kTieBreak - *part;
      }
    }
  }
  reidentified_.clear();
  const tracking::Assignment match = tracking::maximum_weight_assignment(affinity_);
  for (std::size_t slot = 0; slot < slots_.size(); ++slot) {
    if (match[slot] >= 0) {
      ObjectState& lost = slots_[slot];
      ObjectState& found = slots_[static_cast<std::size_t>(match[slot])];
      const std::uint8_t found_slot = found.track().slot;
      found.continue_from(lost, found.observed_position(frame, labels, camera));
      lost.transfer_identity();
      (void)reidentified_.push_back({lost.track().slot, found_slot, lost.track().id});  // as many places as slots
    }
  }
  return reidentified_.span();
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

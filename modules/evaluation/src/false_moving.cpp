#include "false_moving.hpp"

#include <algorithm>
#include <map>

namespace kinetrace::evaluation {
namespace {

/// What is known about a track's object.
struct Followed {
  std::uint32_t object_id = 0;
  bool moving = false;
};

/// A pose without a measurement in this frame comes with a predicted mask, which may lie on another object.
bool is_predicted(const TrackInFrame& track) {
  return track.estimate &&
         (track.estimate->status == BodyStatus::kPropagated || track.estimate->status == BodyStatus::kLost);
}

/// Object of each track in the frame: the matched one, else the one that most of its measured pixels belong to.
std::vector<const TrueObject*> objects_of_tracks(const ObjectFrame& frame, const FrameAssociation& association) {
  std::vector<const TrueObject*> objects(frame.tracks.size(), nullptr);
  for (std::size_t track = 0; track < frame.tracks.size(); ++track) {
    if (frame.tracks[track].covers >= 0 && !is_predicted(frame.tracks[track])) {
      objects[track] = &frame.truth[static_cast<std::size_t>(frame.tracks[track].covers)];
    }
  }
  for (std::size_t object = 0; object < frame.truth.size(); ++object) {
    if (association.matched[object]) {
      objects[*association.matched[object]] = &frame.truth[object];
    }
  }
  return objects;
}

void count(const ObjectFrame& frame, const TrackInFrame& track, const Followed* followed, FalseMovingTrack& report) {
  if (report.frames == 0) {
    report.track_id = track.track_id;
    report.first_frame = frame.frame;
  }
  const double speed_mps = track.estimate->velocity_mps.norm();
  ++report.frames;
  report.mean_speed_mps += (speed_mps - report.mean_speed_mps) / static_cast<double>(report.frames);
  report.last_frame = frame.frame;
  report.object_id = followed != nullptr ? std::optional(followed->object_id) : std::nullopt;
}

}  // namespace

std::vector<FalseMovingTrack> find_false_moving(std::span<const ObjectFrame> frames,
                                                std::span<const FrameAssociation> associations,
                                                const ObjectConfig& config) {
  // A track may begin before its object's first match, so first objects are collected in advance.
  std::map<std::uint32_t, Followed> followed;
  for (std::size_t f = frames.size(); f-- > 0;) {
    const std::vector<const TrueObject*> objects = objects_of_tracks(frames[f], associations[f]);
    for (std::size_t track = 0; track < objects.size(); ++track) {
      if (objects[track] != nullptr) {
        followed[frames[f].tracks[track].track_id] = {objects[track]->id, objects[track]->moving};
      }
    }
  }
  std::map<std::uint32_t, FalseMovingTrack> reports;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const std::vector<const TrueObject*> objects = objects_of_tracks(frames[f], associations[f]);
    for (std::size_t i = 0; i < objects.size(); ++i) {
      const TrackInFrame& track = frames[f].tracks[i];
      if (objects[i] != nullptr) {
        followed[track.track_id] = {objects[i]->id, objects[i]->moving};
      }
      if (!track.estimate || track.estimate->status == BodyStatus::kLost || !track.estimate->moving) {
        continue;
      }
      const auto known = followed.find(track.track_id);
      const Followed* object = known != followed.end() ? &known->second : nullptr;
      if (object != nullptr ? !object->moving : config.truth_is_complete) {
        count(frames[f], track, object, reports[track.track_id]);
      }
    }
  }
  std::vector<FalseMovingTrack> found;
  for (const auto& [track_id, report] : reports) {
    if (report.frames >= static_cast<std::size_t>(config.min_false_moving_frames)) {
      found.push_back(report);
    }
  }
  return found;
}

}  // namespace kinetrace::evaluation

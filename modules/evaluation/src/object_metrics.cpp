#include "kinetrace/evaluation/object_metrics.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "association.hpp"
#include "false_moving.hpp"
#include "rotation_angle.hpp"

namespace kinetrace::evaluation {
namespace {

/// One object in one frame, with its estimate.
struct Observation {
  std::int64_t frame = 0;
  const TrueObject* truth = nullptr;
  double distance_m = 0.0;                        ///< From the camera.
  std::optional<std::uint32_t> matched_track_id;  ///< Matched in this frame.
  std::uint32_t track_id = 0;                     ///< Of `estimate`.
  const TrackEstimate* estimate = nullptr;        ///< Null without a pose, or if it is lost.
};

using Timelines = std::map<std::uint32_t, std::vector<Observation>>;  // By object.

Timelines timelines_of(std::span<const ObjectFrame> frames, std::span<const FrameAssociation> associations) {
  Timelines timelines;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const ObjectFrame& frame = frames[f];
    for (std::size_t object = 0; object < frame.truth.size(); ++object) {
      const TrueObject& truth = frame.truth[object];
      Observation observation;
      observation.frame = frame.frame;
      observation.truth = &truth;
      observation.distance_m = (truth.T_world_obj.translation - frame.T_world_cam_true.translation).norm();
      if (const std::optional<std::size_t> matched = associations[f].matched[object]) {
        observation.matched_track_id = frame.tracks[*matched].track_id;
      }
      if (const std::optional<std::size_t> followed = associations[f].followed[object]) {
        const TrackInFrame& track = frame.tracks[*followed];
        observation.track_id = track.track_id;
        if (track.estimate && track.estimate->status != BodyStatus::kLost) {
          observation.estimate = &*track.estimate;
        }
      }
      timelines[truth.id].push_back(observation);
    }
  }
  return timelines;
}

bool is_tall(const Observation& observation, const ObjectConfig& config) {
  return observation.truth->height_px > config.min_height_px;
}

bool moves_in_range(const Observation& observation, const ObjectConfig& config) {
  return is_tall(observation, config) && observation.truth->moving && observation.distance_m <= config.motion_range_m;
}

bool asks_for_motion(const Observation& observation, const ObjectConfig& config) {
  return moves_in_range(observation, config) && observation.truth->rigid;
}

void add_identity(const std::vector<Observation>& timeline, const ObjectConfig& config, ObjectReport& report) {
  ObjectErrors& errors = report.errors;
  std::optional<std::uint32_t> last_track;
  bool interrupted = false;
  for (const Observation& observation : timeline) {
    ++errors.visible_frames;
    if (is_tall(observation, config)) {
      ++errors.tall_frames;
      errors.covered_frames += observation.estimate != nullptr ? 1 : 0;
    }
    if (!observation.matched_track_id) {
      interrupted = last_track.has_value();
      continue;
    }
    ++errors.matched_frames;
    errors.fragmentations += interrupted ? 1 : 0;
    errors.id_switches += last_track && *last_track != *observation.matched_track_id ? 1 : 0;
    if (last_track != observation.matched_track_id) {
      report.track_ids.push_back(*observation.matched_track_id);
    }
    last_track = observation.matched_track_id;
    interrupted = false;
  }
}

/// Error of the estimated motion in the true body frame.
Se3 motion_error(const Observation& before, const Observation& now) {
  const Se3 H = now.estimate->T_world_obj * before.estimate->T_world_obj.inverse();
  const Se3& L_before = before.truth->T_world_obj;
  const Se3 B = L_before.inverse() * H * L_before;
  const Se3 B_true = L_before.inverse() * now.truth->T_world_obj;
  return B_true.inverse() * B;
}

std::size_t source_of(const Observation& before, const Observation& now) {
  const auto rank = [](const Observation& observation) {
    return std::find(kPoseSources.begin(), kPoseSources.end(), observation.estimate->status) - kPoseSources.begin();
  };
  const auto weaker = static_cast<std::size_t>(std::max(rank(before), rank(now)));
  return std::min(weaker, kPoseSources.size() - 1);
}

MotionSample motion_sample(const Observation& before, const Observation& now) {
  const Se3 error = motion_error(before, now);
  return {.frame = now.frame,
          .object_id = now.truth->id,
          .track_id = now.track_id,
          .source = kPoseSources[source_of(before, now)],
          .translation_m = error.translation.norm(),
          .rotation_deg = rotation_angle_deg(error.rotation),
          .distance_m = now.distance_m,
          .height_px = now.truth->height_px};
}

void add_motions(const std::vector<Observation>& timeline, const ObjectConfig& config, ObjectErrors& errors,
                 std::vector<MotionSample>& samples) {
  for (std::size_t i = 1; i < timeline.size(); ++i) {
    const Observation& before = timeline[i - 1];
    const Observation& now = timeline[i];
    if (now.frame != before.frame + 1 || !asks_for_motion(before, config) || !asks_for_motion(now, config)) {
      continue;
    }
    if (before.estimate == nullptr || now.estimate == nullptr || before.track_id != now.track_id) {
      ++errors.missing_motions;
      continue;
    }
    const MotionSample& sample = samples.emplace_back(motion_sample(before, now));
    MotionErrors motion;
    motion.translation_m.add(sample.translation_m);
    motion.rotation_deg.add(sample.rotation_deg);
    errors.motion.add(motion);
    errors.motion_by_source[source_of(before, now)].add(motion);
  }
}

/// Of moving objects: velocities, and where those are that have no body frame.
void add_moving_poses(const std::vector<Observation>& timeline, const ObjectConfig& config, ObjectErrors& errors) {
  for (const Observation& observation : timeline) {
    if (observation.estimate == nullptr || !moves_in_range(observation, config)) {
      continue;
    }
    const TrackEstimate& estimate = *observation.estimate;
    const Eigen::Vector3d& velocity_mps = observation.truth->velocity_mps;
    const double speed_error_mps = std::abs(estimate.velocity_mps.norm() - velocity_mps.norm());
    if (!observation.truth->rigid) {
      errors.walking_speed_mps.add(speed_error_mps);
      errors.walking_distance_m.add((estimate.box.center_m - observation.truth->center_m).norm());
      ++errors.walking_rows;
      errors.found_walking_rows += estimate.moving ? 1U : 0U;
      continue;
    }
    errors.speed_mps.add(speed_error_mps);
    ++errors.moving_rows;
    if (estimate.moving) {
      ++errors.found_moving_rows;
      const double heading_rad = std::atan2(-velocity_mps.z(), velocity_mps.x());
      const double off_rad = std::remainder(estimate.heading_rad - heading_rad, 2.0 * std::numbers::pi);
      errors.heading_deg.add(std::abs(off_rad) * kDegPerRad);
    }
  }
}

void add_distances(const std::vector<Observation>& timeline, const ObjectConfig& config, ObjectErrors& errors) {
  std::map<std::uint32_t, std::vector<Eigen::Vector3d>> offsets_of_track;  // In the true body frame.
  for (const Observation& observation : timeline) {
    if (observation.estimate == nullptr || !is_tall(observation, config) ||
        observation.distance_m > config.distance_range_m) {
      continue;
    }
    errors.center_m.add((observation.estimate->box.center_m - observation.truth->center_m).norm());
    const Se3& L = observation.truth->T_world_obj;
    offsets_of_track[observation.track_id].push_back(L.inverse() * observation.estimate->T_world_obj.translation);
  }
  for (const auto& [track_id, offsets] : offsets_of_track) {
    if (offsets.size() < config.min_track_rows) {
      continue;
    }
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& offset : offsets) {
      mean += offset / static_cast<double>(offsets.size());
    }
    errors.offset_m.add(mean.norm());
    for (const Eigen::Vector3d& offset : offsets) {
      errors.distance_m.add((offset - mean).norm());
    }
  }
}

/// All boxes are compared, including those with predicted poses.
void add_boxes(const std::vector<Observation>& timeline, const ObjectConfig& config, BoxMetrics& boxes) {
  std::map<std::uint32_t, std::int64_t> first_frames;  // By track.
  for (const Observation& observation : timeline) {
    if (observation.estimate == nullptr) {
      continue;
    }
    const std::int64_t first = first_frames.try_emplace(observation.track_id, observation.frame).first->second;
    if (!is_tall(observation, config) || !observation.truth->rigid) {
      continue;
    }
    const TrueObject& truth = *observation.truth;
    const BoxStage stage = observation.frame - first < kEarlyFrames ? BoxStage::kEarly
                           : truth.hidden >= kHalfHidden            ? BoxStage::kHidden
                                                                    : BoxStage::kSeen;
    compare({{truth.T_world_obj.rotation, truth.center_m}, truth.size_m}, observation.estimate->box,
            observation.estimate->box_sigma, boxes.cell(truth.moving, observation.distance_m, stage));
  }
}

ObjectReport report_on(std::uint32_t id, const std::vector<Observation>& timeline, const ObjectConfig& config,
                       std::vector<MotionSample>& motions) {
  ObjectReport report;
  report.id = id;
  report.class_id = timeline.front().truth->class_id;
  report.rigid = timeline.front().truth->rigid;
  report.moving = std::any_of(timeline.begin(), timeline.end(), [](const Observation& s) { return s.truth->moving; });
  add_identity(timeline, config, report);
  add_motions(timeline, config, report.errors, motions);
  add_moving_poses(timeline, config, report.errors);
  add_distances(timeline, config, report.errors);
  return report;
}

void add(const ObjectErrors& one, bool rigid, ObjectErrors& all) {
  all.visible_frames += one.visible_frames;
  all.matched_frames += one.matched_frames;
  all.tall_frames += one.tall_frames;
  all.covered_frames += one.covered_frames;
  all.id_switches += one.id_switches;
  all.fragmentations += one.fragmentations;
  all.motion.add(one.motion);
  for (std::size_t i = 0; i < kPoseSources.size(); ++i) {
    all.motion_by_source[i].add(one.motion_by_source[i]);
  }
  all.missing_motions += one.missing_motions;
  // Non-rigid objects have no body frame in which an offset could be constant.
  if (rigid) {
    all.distance_m.add(one.distance_m);
    all.offset_m.add(one.offset_m);
    all.center_m.add(one.center_m);
  }
  all.speed_mps.add(one.speed_mps);
  all.heading_deg.add(one.heading_deg);
  all.moving_rows += one.moving_rows;
  all.found_moving_rows += one.found_moving_rows;
  all.walking_speed_mps.add(one.walking_speed_mps);
  all.walking_distance_m.add(one.walking_distance_m);
  all.walking_rows += one.walking_rows;
  all.found_walking_rows += one.found_walking_rows;
}

}  // namespace

ObjectMetrics evaluate_objects(std::span<const ObjectFrame> frames, const ObjectConfig& config) {
  const std::vector<FrameAssociation> associations = associate(frames, config.min_similarity);
  ObjectMetrics metrics;
  for (const auto& [id, timeline] : timelines_of(frames, associations)) {
    metrics.objects.push_back(report_on(id, timeline, config, metrics.motions));
    add(metrics.objects.back().errors, metrics.objects.back().rigid, metrics.all);
    add_boxes(timeline, config, metrics.boxes);
  }
  metrics.false_moving = find_false_moving(frames, associations, config);
  return metrics;
}

}  // namespace kinetrace::evaluation

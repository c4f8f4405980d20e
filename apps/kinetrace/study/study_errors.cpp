#include "study/study_errors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "kinetrace/core/quantiles.hpp"
#include "kinetrace/evaluation/matching.hpp"

namespace kinetrace::app {
namespace {

constexpr double kMinOverlap = 0.5;
constexpr double kWrong = 0.2;
constexpr std::size_t kMinPoints = 5;  // Fewer points determine no shape.
constexpr int kMinTrackRows = 5;       // Fewer rows are fitted too well by an offset.
constexpr int kMinObservations = 2;    // As in a run's point clouds: a single observation may be an outlier.
constexpr std::int64_t kMotsIdsPerClass = 1000;

std::vector<evaluation::MaskInstance> tracked_instances(const FrameResult& result) {
  std::vector<evaluation::MaskInstance> instances;
  for (const Track& track : result.tracks) {
    instances.push_back({track.label(), track.id, track.class_id});
  }
  return instances;
}

std::vector<double> deviations(std::vector<double> values, double from) {
  std::transform(values.begin(), values.end(), values.begin(), [from](double v) { return std::abs(v - from); });
  return values;
}

struct MotionError {
  double translation_m = 0.0;
  double rotation_deg = 0.0;
};

/// Error of the motion from one pose to the next, in the true body frame `L`.
MotionError motion_error(const Se3& L_before, const Se3& L, const Se3& T_before, const Se3& T) {
  const Se3 H = T * T_before.inverse();
  const Se3 error = (L_before.inverse() * L).inverse() * (L_before.inverse() * H * L_before);
  return {error.translation.norm(), so3_log(error.rotation).norm() * 180.0 / std::numbers::pi};
}

const ObjectResult* find_object(std::span<const ObjectResult> objects, std::uint32_t track_id) {
  const auto found =
      std::find_if(objects.begin(), objects.end(), [&](const ObjectResult& o) { return o.track_id == track_id; });
  return found != objects.end() ? &*found : nullptr;
}

/// Depth minus true depth of the track's points that this frame sees.
std::vector<double> depth_errors(const FrameResult& result, std::uint32_t track_id, const TrueImages& images,
                                 std::uint8_t true_label) {
  std::vector<double> errors;
  const ObjectResult* object = find_object(result.newest.objects, track_id);
  const auto body = std::find_if(result.bodies.begin(), result.bodies.end(),
                                 [&](const BodyGeometry& b) { return b.track_id == track_id; });
  if (object == nullptr || object->status != BodyStatus::kTracked || body == result.bodies.end()) {
    return errors;
  }
  const Se3 T_cam_obj = object->T_obj_cam.inverse();
  std::map<std::uint32_t, Eigen::Vector3d> position_of;
  for (const BodyPoint& point : body->points) {
    if (point.observations >= kMinObservations) {
      position_of.emplace(point.id, point.position_m.cast<double>());
    }
  }
  for (const PointObservation& observation : body->observations) {
    const auto point = position_of.find(observation.point_id);
    const auto true_depth_m = images.depth_at(double{observation.u_left_px}, double{observation.v_px}, true_label);
    if (point != position_of.end() && true_depth_m) {
      errors.push_back((T_cam_obj * point->second).z() - *true_depth_m);
    }
  }
  return errors;
}

void measure_points(const std::vector<double>& errors_m, StudyRow& row) {
  row.points = static_cast<int>(errors_m.size());
  if (errors_m.size() >= kMinPoints) {
    row.depth_bias_m = median(std::vector(errors_m));
    row.depth_m = median(deviations(errors_m, 0.0));
    row.shape_m = median(deviations(errors_m, *row.depth_bias_m));
    const auto wrong = std::count_if(errors_m.begin(), errors_m.end(),
                                     [&](double error) { return std::abs(error) > kWrong * row.distance_m; });
    row.wrong_points = static_cast<double>(wrong) / static_cast<double>(errors_m.size());
  }
}

}  // namespace

Status StudyErrors::add(const FrameResult& result) {
  if (!result.pair.left.empty()) {  // Empty while draining: finalised poses only.
    if (Status begun = begin_frame(result); !begun) {
      return begun;
    }
  }
  if (result.has_finalised) {
    finalise(result.finalised);
  }
  return {};
}

Status StudyErrors::begin_frame(const FrameResult& result) {
  const std::int64_t frame = result.newest.frame_index;
  const std::vector<evaluation::LocatedObject> objects = truth_.objects(frame);
  const std::optional<Se3> T_world_cam = truth_.camera_pose(frame);
  if (objects.empty() || !T_world_cam) {
    return {};
  }
  const Result<TrueImages> images = truth_.images(frame);
  if (!images) {
    return Unexpected(images.error());
  }
  const std::vector<evaluation::MaskInstance> tracks = tracked_instances(result);
  const auto overlap = evaluation::overlap_masks(images->masks.masks(), {result.left_labels, tracks});
  if (!overlap) {
    return Unexpected(overlap.error());
  }
  const std::vector<int> track_of =
      evaluation::best_matching((overlap->iou.array() < kMinOverlap).select(0.0, overlap->iou));
  for (const evaluation::LocatedObject& object : objects) {
    StudyRow row;
    row.frame = frame;
    row.object_id = object.object.id;
    row.distance_m = (object.center_m - T_world_cam->translation).norm();
    row.height_px = object.object.height_px;
    for (std::size_t i = 0; i < track_of.size(); ++i) {
      const evaluation::MaskInstance& instance = images->masks.instances[i];
      if (instance.id % kMotsIdsPerClass == object.object.id && track_of[i] >= 0) {
        row.track_id = static_cast<std::uint32_t>(tracks[static_cast<std::size_t>(track_of[i])].id);
        measure_points(depth_errors(result, row.track_id, *images, instance.label), row);
      }
    }
    samples_.emplace(Key{row.object_id, frame}, Sample{row, object, *T_world_cam, std::nullopt, std::nullopt});
  }
  return {};
}

void StudyErrors::finalise(const FrameEstimate& finalised) {
  for (auto& [key, sample] : samples_) {
    if (key.second != finalised.frame_index) {
      continue;
    }
    const ObjectResult* object = find_object(finalised.objects, sample.row.track_id);
    if (object == nullptr) {
      continue;
    }
    sample.row.status = object->status;
    if (object->status != BodyStatus::kLost && object->status != BodyStatus::kInitializing) {
      sample.published = object->T_world_obj;
    }
    if (object->status != BodyStatus::kTracked) {
      continue;
    }
    sample.T_world_obj = sample.T_world_cam_true * object->T_obj_cam.inverse();
    if (object->box.size_m.maxCoeff() > 0.0) {
      const Eigen::Vector3d center_obj_m = object->T_world_obj.inverse() * object->box.center_m;
      sample.row.center_m = (*sample.T_world_obj * center_obj_m - sample.truth.center_m).norm();
    }
  }
}

std::vector<StudyRow> StudyErrors::rows() const {
  struct Offset {
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
    double weight = 0.0;
  };
  std::map<std::pair<std::uint32_t, std::uint32_t>, Offset> offsets;  // By object and track.
  for (const auto& [key, sample] : samples_) {
    if (sample.T_world_obj) {
      Offset& offset = offsets[{key.first, sample.row.track_id}];
      const double weight = std::pow(sample.row.distance_m, -4.0);
      offset.sum_m += weight * (sample.T_world_obj->inverse() * sample.truth.center_m);
      offset.weight += weight;
    }
  }
  std::vector<StudyRow> rows;
  const Sample* before = nullptr;
  for (const auto& [key, sample] : samples_) {
    StudyRow row = sample.row;
    if (sample.T_world_obj) {
      const Offset& offset = offsets.at({key.first, row.track_id});
      row.position_m = (*sample.T_world_obj * (offset.sum_m / offset.weight) - sample.truth.center_m).norm();
      if (before != nullptr && before->T_world_obj && consecutive(*before, sample)) {
        const MotionError error = motion_error(before->truth.object.T_world_obj, sample.truth.object.T_world_obj,
                                               *before->T_world_obj, *sample.T_world_obj);
        row.motion_m = error.translation_m;
        row.motion_deg = error.rotation_deg;
      }
    }
    rows.push_back(row);
    before = &sample;
  }
  measure_published(rows);
  return rows;
}

bool StudyErrors::consecutive(const Sample& before, const Sample& after) {
  return before.row.object_id == after.row.object_id && before.row.track_id == after.row.track_id &&
         before.row.frame + 1 == after.row.frame;
}

void StudyErrors::measure_published(std::vector<StudyRow>& rows) const {
  struct Offsets {
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
    int count = 0;
  };
  const auto offset = [](const Sample& sample) -> Eigen::Vector3d {
    return sample.truth.object.T_world_obj.inverse() * sample.published->translation;
  };
  std::map<std::pair<std::uint32_t, std::uint32_t>, Offsets> offsets;  // By object and track.
  for (const auto& [key, sample] : samples_) {
    if (sample.published) {
      Offsets& all = offsets[{key.first, sample.row.track_id}];
      all.sum_m += offset(sample);
      ++all.count;
    }
  }
  const Sample* before = nullptr;
  auto row = rows.begin();
  for (const auto& [key, sample] : samples_) {
    if (sample.published) {
      const Offsets& all = offsets.at({key.first, sample.row.track_id});
      if (all.count >= kMinTrackRows) {
        row->published_place_m = (offset(sample) - all.sum_m / all.count).norm();
      }
      if (before != nullptr && before->published && consecutive(*before, sample)) {
        const MotionError error = motion_error(before->truth.object.T_world_obj, sample.truth.object.T_world_obj,
                                               *before->published, *sample.published);
        row->published_motion_m = error.translation_m;
        row->published_motion_deg = error.rotation_deg;
      }
    }
    before = &sample;
    ++row;
  }
}

}  // namespace kinetrace::app

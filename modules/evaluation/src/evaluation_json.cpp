#include <algorithm>
#include <iterator>

#include <nlohmann/json.hpp>

#include "kinetrace/core/class_name.hpp"
#include "kinetrace/evaluation/evaluation.hpp"
#include "shares.hpp"

namespace kinetrace::evaluation {
namespace {

using Json = nlohmann::ordered_json;

Json value_of(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json errors_json(const ErrorStatistics& errors) {
  return {{"mean", value_of(errors.mean())},
          {"rmse", value_of(errors.rmse())},
          {"max", value_of(errors.max())},
          {"count", errors.count()}};
}

Json camera_json(const Evaluation& evaluation) {
  const CameraMetrics& camera = evaluation.camera;
  Json segments = Json::array();
  for (const SegmentErrors& segment : camera.segments) {
    segments.push_back({{"length", segment.length_m},
                        {"count", segment.count},
                        {"t_rel", segment.t_rel_percent},
                        {"r_rel", segment.r_rel_deg_per_m}});
  }
  return {
      {"frames", camera.frames},
      {"path", camera.path_m},
      {"t_rel", value_of(camera.t_rel_percent)},
      {"r_rel", value_of(camera.r_rel_deg_per_m)},
      {"segments", std::move(segments)},
      {"ate",
       {{"first", errors_json(camera.ate_m.first)},
        {"se3", errors_json(camera.ate_m.se3)},
        {"sim3", errors_json(camera.ate_m.sim3)},
        {"scale", value_of(camera.ate_m.scale)}}},
      {"rpe",
       {{"translation", errors_json(camera.rpe_translation_m)}, {"rotation", errors_json(camera.rpe_rotation_deg)}}},
      {"frame_rotation", value_of(evaluation.camera_rotation_deg)}};
}

Json motion_json(const MotionErrors& motion) {
  return {{"translation", errors_json(motion.translation_m)}, {"rotation", errors_json(motion.rotation_deg)}};
}

Json object_errors_json(const ObjectErrors& errors) {
  Json motion = motion_json(errors.motion);
  motion["pairs"] = errors.motion.translation_m.count();
  motion["missing"] = errors.missing_motions;
  for (std::size_t i = 0; i < kPoseSources.size(); ++i) {
    motion[std::string(kinetrace::to_string(kPoseSources[i]))] = motion_json(errors.motion_by_source[i]);
  }
  return {{"visible_frames", errors.visible_frames},
          {"matched_frames", errors.matched_frames},
          {"tall_frames", errors.tall_frames},
          {"covered_frames", errors.covered_frames},
          {"coverage", value_of(percent(errors.covered_frames, errors.tall_frames))},
          {"id_switches", errors.id_switches},
          {"fragmentations", errors.fragmentations},
          {"motion", std::move(motion)},
          {"distance", errors_json(errors.distance_m)},
          {"offset", errors_json(errors.offset_m)},
          {"center", errors_json(errors.center_m)},
          {"speed", errors_json(errors.speed_mps)},
          {"heading", errors_json(errors.heading_deg)},
          {"moving_found", value_of(percent(errors.found_moving_rows, errors.moving_rows))},
          {"walking_speed", errors_json(errors.walking_speed_mps)},
          {"walking_distance", errors_json(errors.walking_distance_m)},
          {"walking_found", value_of(percent(errors.found_walking_rows, errors.walking_rows))}};
}

Json false_moving_json(const std::vector<FalseMovingTrack>& tracks) {
  Json list = Json::array();
  for (const FalseMovingTrack& track : tracks) {
    list.push_back({{"track", track.track_id},
                    {"frames", track.frames},
                    {"first_frame", track.first_frame},
                    {"last_frame", track.last_frame},
                    {"speed", track.mean_speed_mps},
                    {"object", track.object_id ? Json(*track.object_id) : Json(nullptr)}});
  }
  return list;
}

// Starting points for an analysis.
Json worst_motions_json(std::vector<MotionSample> motions) {
  constexpr std::ptrdiff_t kListed = 10;
  const auto end = motions.begin() + std::min(kListed, std::ssize(motions));
  std::partial_sort(motions.begin(), end, motions.end(),
                    [](const MotionSample& a, const MotionSample& b) { return a.translation_m > b.translation_m; });
  Json list = Json::array();
  for (auto motion = motions.begin(); motion != end; ++motion) {
    list.push_back({{"frame", motion->frame},
                    {"object", motion->object_id},
                    {"track", motion->track_id},
                    {"source", kinetrace::to_string(motion->source)},
                    {"translation", motion->translation_m},
                    {"rotation", motion->rotation_deg},
                    {"distance", motion->distance_m},
                    {"height_px", motion->height_px}});
  }
  return list;
}

Json box_errors_json(const BoxErrors& errors) {
  return {{"iou_3d", value_of(errors.iou_3d.mean())},
          {"iou_footprint", value_of(errors.iou_footprint.mean())},
          {"center", errors_json(errors.center_m)},
          {"length", errors_json(errors.size_m[0])},
          {"height", errors_json(errors.size_m[1])},
          {"width", errors_json(errors.size_m[2])},
          {"yaw", errors_json(errors.yaw_deg)},
          {"headings_known", value_of(percent(errors.known_headings, errors.yaw_deg.count()))},
          {"headings_turned", value_of(percent(errors.known_turned, errors.known_headings))},
          {"center_normalised", value_of(errors.center_normalised.mean_square())},
          {"size_normalised", value_of(errors.size_normalised.mean_square())},
          {"yaw_normalised", value_of(errors.yaw_normalised.mean_square())}};
}

Json boxes_json(const BoxMetrics& boxes) {
  Json json = Json::object();
  for (const bool moving : {true, false}) {
    Json& by_distance = json[moving ? "moving" : "rest"];
    for (std::size_t distance = 0; distance < kBoxDistanceNames.size(); ++distance) {
      for (std::size_t stage = 0; stage < kBoxStages.size(); ++stage) {
        by_distance[std::string(kBoxDistanceNames[distance])][std::string(kBoxStages[stage])] =
            box_errors_json(boxes.cells[moving ? 1 : 0][distance][stage]);
      }
    }
  }
  return json;
}

Json objects_json(const Evaluation& evaluation) {
  const ObjectMetrics& objects = *evaluation.objects;
  const ObjectConfig& config = evaluation.object_config;
  Json json = {{"count", objects.objects.size()},
               {"association", to_string(evaluation.association)},
               {"min_height_px", config.min_height_px},
               {"motion_range", config.motion_range_m},
               {"distance_range", config.distance_range_m}};
  json.update(object_errors_json(objects.all));
  json["false_moving"] = objects.false_moving.size();
  json["false_moving_tracks"] = false_moving_json(objects.false_moving);
  json["boxes"] = boxes_json(objects.boxes);
  json["worst_motions"] = worst_motions_json(objects.motions);
  json["each"] = Json::array();
  for (const ObjectReport& object : objects.objects) {
    Json one = {{"id", object.id},
                {"class", ClassName(object.class_id).view()},
                {"moving", object.moving},
                {"rigid", object.rigid},
                {"tracks", object.track_ids}};
    one.update(object_errors_json(object.errors));
    json["each"].push_back(std::move(one));
  }
  return json;
}

Json scores_json(const MaskScores& scores) {
  const auto percent_of = [](double share) { return 100.0 * share; };
  const auto of_truth = [&](double share) { return scores.mots.has_truth() ? Json(percent_of(share)) : Json(nullptr); };
  return {{"hota", percent_of(scores.hota.hota())},
          {"deta", percent_of(scores.hota.deta())},
          {"assa", percent_of(scores.hota.assa())},
          {"loca", percent_of(scores.hota.loca())},
          {"detre", percent_of(scores.hota.detre())},
          {"detpr", percent_of(scores.hota.detpr())},
          {"assre", percent_of(scores.hota.assre())},
          {"asspr", percent_of(scores.hota.asspr())},
          {"smotsa", of_truth(scores.mots.smotsa())},
          {"motsa", of_truth(scores.mots.motsa())},
          {"motsp", percent_of(scores.mots.motsp())},
          {"id_switches", scores.mots.id_switches},
          {"tp", scores.mots.tp},
          {"fn", scores.mots.fn},
          {"fp", scores.mots.fp}};
}

Json masks_json(const MaskReport& masks) {
  Json json = scores_json(masks.combined);
  json["classless"] = masks.is_classless;
  json["any_class"] = scores_json(masks.any_class);
  json["classes"] = Json::object();
  for (const auto& [class_id, scores] : masks.classes) {
    json["classes"][ClassName(class_id).c_str()] = scores_json(scores);
  }
  return json;
}

}  // namespace

std::string evaluation_json(const Evaluation& evaluation) {
  const Json json = {{"run", evaluation.run},
                     {"truth", evaluation.truth},
                     {"truth_format", evaluation.truth_format},
                     {"notes", evaluation.notes},
                     {"camera", camera_json(evaluation)},
                     {"objects", evaluation.objects ? objects_json(evaluation) : Json(nullptr)},
                     {"masks", evaluation.masks ? masks_json(*evaluation.masks) : Json(nullptr)}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace kinetrace::evaluation

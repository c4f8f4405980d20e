#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>

#include "kinetrace/core/class_name.hpp"
#include "kinetrace/evaluation/evaluation.hpp"
#include "shares.hpp"

namespace kinetrace::evaluation {
namespace {

/// Text assembled line by line.
class Lines {
 public:
  // NOLINTNEXTLINE(cert-dcl50-cpp): the attribute lets the compiler check the arguments.
  __attribute__((format(printf, 2, 3))) void add(const char* format, ...) {
    std::array<char, 512> line{};
    va_list arguments;
    va_start(arguments, format);
    const int length = std::vsnprintf(line.data(), line.size(), format, arguments);
    va_end(arguments);
    text_.append(line.data(), std::min(static_cast<std::size_t>(std::max(length, 0)), line.size() - 1));
    text_ += '\n';
  }
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

std::string number(const std::optional<double>& value, int decimals) {
  if (!value) {
    return "none";
  }
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, *value);
  return text.data();
}

void add_errors(Lines& lines, const char* name, const char* unit, const ErrorStatistics& errors, int decimals,
                const std::string& note = "") {
  lines.add("  %-24s %10s %10s %10s  %-5s %s", name, number(errors.mean(), decimals).c_str(),
            number(errors.rmse(), decimals).c_str(), number(errors.max(), decimals).c_str(), unit, note.c_str());
}

std::string lengths_text(const CameraMetrics& camera) {
  if (camera.segments.empty()) {
    return "the path is too short";
  }
  std::string text = "over";
  for (const SegmentErrors& segment : camera.segments) {
    text += text.size() > 4 ? ", " : " ";
    text += number(segment.length_m, 0);
  }
  return text + " m";
}

void add_camera(Lines& lines, const Evaluation& evaluation) {
  const CameraMetrics& camera = evaluation.camera;
  lines.add("Camera: %zu frames, %.2f m", camera.frames, camera.path_m);
  lines.add("  %-24s %10s  %-5s %s", "t_rel", number(camera.t_rel_percent, 3).c_str(), "%",
            lengths_text(camera).c_str());
  lines.add("  %-24s %10s  %-5s", "r_rel", number(camera.r_rel_deg_per_m, 4).c_str(), "deg/m");
  lines.add("  %-24s %10s %10s %10s", "", "mean", "RMSE", "max");
  add_errors(lines, "ATE, first pose aligned", "m", camera.ate_m.first, 4);
  add_errors(lines, "ATE, SE(3) aligned", "m", camera.ate_m.se3, 4);
  add_errors(lines, "ATE, Sim(3) aligned", "m", camera.ate_m.sim3, 4, "scale " + number(camera.ate_m.scale, 5));
  add_errors(lines, "RPE per frame", "m", camera.rpe_translation_m, 4);
  add_errors(lines, "", "deg", camera.rpe_rotation_deg, 4);
  if (evaluation.camera_rotation_deg) {
    lines.add("  The frame of the estimated camera was turned by %.3f deg, the same in all frames.",
              *evaluation.camera_rotation_deg);
  }
}

void add_motion(Lines& lines, const char* name, const MotionErrors& motion) {
  add_errors(lines, name, "m", motion.translation_m, 4, std::to_string(motion.translation_m.count()) + " pairs");
  add_errors(lines, "", "deg", motion.rotation_deg, 3);
}

void add_all_objects(Lines& lines, const ObjectMetrics& metrics, const ObjectConfig& config) {
  const ObjectErrors& all = metrics.all;
  lines.add("  %-24s %10s  %-5s %zu of %zu frames over %.0f px tall", "coverage",
            number(percent(all.covered_frames, all.tall_frames), 2).c_str(), "%", all.covered_frames, all.tall_frames,
            config.min_height_px);
  lines.add("  %-24s %10zu", "id switches", all.id_switches);
  lines.add("  %-24s %10zu", "fragmentations", all.fragmentations);
  lines.add("  %-24s %10s  %-5s rigid", "seen to move",
            number(percent(all.found_moving_rows, all.moving_rows), 2).c_str(), "%");
  lines.add("  %-24s %10s  %-5s not rigid", "people seen to move",
            number(percent(all.found_walking_rows, all.walking_rows), 2).c_str(), "%");
  lines.add("  %-24s %10s %10s %10s", "", "mean", "RMSE", "max");
  add_motion(lines, "motion per frame", all.motion);
  for (std::size_t i = 0; i < kPoseSources.size(); ++i) {
    if (all.motion_by_source[i].translation_m.count() > 0) {
      add_motion(lines, std::string("  ").append(kinetrace::to_string(kPoseSources[i])).c_str(),
                 all.motion_by_source[i]);
    }
  }
  lines.add("  %-24s %10zu  %-5s moving, rigid, over %.0f px tall, within %.0f m", "  missing", all.missing_motions,
            "pairs", config.min_height_px, config.motion_range_m);
  const auto worst =
      std::max_element(metrics.motions.begin(), metrics.motions.end(),
                       [](const MotionSample& a, const MotionSample& b) { return a.translation_m < b.translation_m; });
  if (worst != metrics.motions.end()) {
    lines.add("  %-24s %10.4f  %-5s object %u, track %u, frame %lld", "  worst", worst->translation_m, "m",
              worst->object_id, worst->track_id, static_cast<long long>(worst->frame));
  }
  add_errors(lines, "distance from trajectory", "m", all.distance_m, 4,
             "rigid, within " + number(config.distance_range_m, 0) + " m");
  add_errors(lines, "  offset taken out", "m", all.offset_m, 3, std::to_string(all.offset_m.count()) + " tracks");
  add_errors(lines, "centre of the box", "m", all.center_m, 3);
  add_errors(lines, "  of moving people", "m", all.walking_distance_m, 3);
  add_errors(lines, "speed", "m/s", all.speed_mps, 3);
  add_errors(lines, "  of people", "m/s", all.walking_speed_mps, 3);
  add_errors(lines, "heading", "deg", all.heading_deg, 2);
  lines.add("  %-24s %10zu", "false moving tracks", metrics.false_moving.size());
  for (const FalseMovingTrack& track : metrics.false_moving) {
    lines.add("    track %u: %zu frames from %lld to %lld at %.2f m/s, %s", track.track_id, track.frames,
              static_cast<long long>(track.first_frame), static_cast<long long>(track.last_frame), track.mean_speed_mps,
              track.object_id
                  ? std::string("object ").append(std::to_string(*track.object_id)).append(" is at rest").c_str()
                  : "there is no object");
  }
}

void add_boxes(Lines& lines, const BoxMetrics& boxes) {
  constexpr std::array<const char*, kBoxDistanceNames.size()> kDistances{"under 20 m", "20 to 40 m", "over 40 m"};
  lines.add("  %-24s %8s %8s %8s %8s %8s %8s %8s %8s %8s", "boxes", "count", "IoU 3-D", "IoU 2-D", "centre m",
            "length m", "height m", "width m", "yaw deg", "turned %");
  for (const bool moving : {true, false}) {
    for (std::size_t distance = 0; distance < kDistances.size(); ++distance) {
      for (std::size_t stage = 0; stage < kBoxStages.size(); ++stage) {
        const BoxErrors& errors = boxes.cells[moving ? 1 : 0][distance][stage];
        if (errors.iou_3d.count() == 0) {
          continue;
        }
        const std::string name = std::string(moving ? "  moving, " : "  at rest, ") + kDistances[distance] + ", " +
                                 std::string(kBoxStages[stage]);
        lines.add("  %-30s %2zu %8s %8s %8s %8s %8s %8s %8s %8s", name.c_str(), errors.iou_3d.count(),
                  number(errors.iou_3d.mean(), 3).c_str(), number(errors.iou_footprint.mean(), 3).c_str(),
                  number(errors.center_m.mean(), 3).c_str(), number(errors.size_m[0].mean(), 3).c_str(),
                  number(errors.size_m[1].mean(), 3).c_str(), number(errors.size_m[2].mean(), 3).c_str(),
                  number(errors.yaw_deg.mean(), 2).c_str(),
                  number(percent(errors.known_turned, errors.known_headings), 1).c_str());
      }
    }
  }
}

std::string tracks_text(const std::vector<std::uint32_t>& track_ids) {
  constexpr std::size_t kMax = 4;
  std::string text;
  for (std::size_t i = 0; i < std::min(track_ids.size(), kMax); ++i) {
    text += i > 0 ? "," : "";
    text += std::to_string(track_ids[i]);
  }
  return text.append(track_ids.size() > kMax ? ",..." : text.empty() ? "none" : "");
}

void add_each_object(Lines& lines, const ObjectMetrics& metrics) {
  lines.add("  %6s %-11s %-6s %6s %6s %8s %8s %8s %8s %8s %8s %8s  %s", "object", "class", "state", "frames", "tall",
            "cover %", "switches", "motion m", "deg", "dist. m", "m/s", "head. deg", "tracks");
  for (const ObjectReport& object : metrics.objects) {
    const ObjectErrors& errors = object.errors;
    lines.add("  %6u %-11s %-6s %6zu %6zu %8s %8zu %8s %8s %8s %8s %8s  %s", object.id,
              ClassName(object.class_id).c_str(), object.moving ? "moving" : "rest", errors.visible_frames,
              errors.tall_frames, number(percent(errors.covered_frames, errors.tall_frames), 1).c_str(),
              errors.id_switches, number(errors.motion.translation_m.mean(), 4).c_str(),
              number(errors.motion.rotation_deg.mean(), 3).c_str(), number(errors.distance_m.mean(), 4).c_str(),
              number(errors.speed_mps.mean(), 3).c_str(), number(errors.heading_deg.mean(), 2).c_str(),
              tracks_text(object.track_ids).c_str());
  }
}

void add_scores(Lines& lines, const std::string& name, const MaskScores& scores) {
  if (!scores.mots.has_truth()) {
    lines.add("  %-24s %8s: the truth has no such mask, the run %lld", name.c_str(), "none",
              static_cast<long long>(scores.mots.fp));
    return;
  }
  lines.add("  %-24s %8.2f %8.2f %8.2f %8.2f %8.2f %8lld", name.c_str(), 100.0 * scores.hota.hota(),
            100.0 * scores.hota.deta(), 100.0 * scores.hota.assa(), 100.0 * scores.mots.smotsa(),
            100.0 * scores.mots.motsa(), static_cast<long long>(scores.mots.id_switches));
}

void add_masks(Lines& lines, const MaskReport& masks) {
  lines.add("Masks, in %%");
  lines.add("  %-24s %8s %8s %8s %8s %8s %8s", "", "HOTA", "DetA", "AssA", "sMOTSA", "MOTSA", "switches");
  for (const auto& [class_id, scores] : masks.classes) {
    add_scores(lines, std::string(ClassName(class_id).view()), scores);
  }
  if (!masks.is_classless) {
    add_scores(lines, "all classes", masks.combined);
  }
  add_scores(lines, "whatever class", masks.any_class);
  if (masks.is_classless) {
    lines.add("  %s", "the run's masks have no class (moving regions), so there are no scores by class");
  }
}

}  // namespace

std::string_view to_string(Association association) noexcept {
  switch (association) {
    case Association::kMasks: return "masks";
    case Association::kBoxes: return "boxes";
    case Association::kCentres: return "centres";
  }
  return "masks";
}

std::string evaluation_table(const Evaluation& evaluation) {
  Lines lines;
  lines.add("%s against %s (%s)", evaluation.run.c_str(), evaluation.truth.c_str(), evaluation.truth_format.c_str());
  lines.add("%s", "");
  add_camera(lines, evaluation);
  lines.add("%s", "");
  if (evaluation.objects) {
    lines.add("Objects: %zu seen, matched by %s", evaluation.objects->objects.size(),
              std::string(to_string(evaluation.association)).c_str());
    add_all_objects(lines, *evaluation.objects, evaluation.object_config);
    add_boxes(lines, evaluation.objects->boxes);
    lines.add("%s", "");
    add_each_object(lines, *evaluation.objects);
  } else {
    lines.add("Objects: none in the truth");
  }
  if (evaluation.masks) {
    lines.add("%s", "");
    add_masks(lines, *evaluation.masks);
  }
  return lines.take();
}

}  // namespace kinetrace::evaluation

// Prints the contents of a run folder as a table.
#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "cli/commands.hpp"
#include "cli/messages.hpp"
#include "cli/printable.hpp"
#include "kinetrace/core/class_name.hpp"
#include "kinetrace/recording/run_reader.hpp"
#include "run/run_tally.hpp"

namespace kinetrace::app {
namespace {

using Json = nlohmann::ordered_json;
using recording::ObjectRow;
using recording::Run;

struct SummaryOptions {
  std::filesystem::path run;
  bool json = false;
};

constexpr std::array<BodyStatus, 3> kWithPose{BodyStatus::kTracked, BodyStatus::kStereoOnly, BodyStatus::kPropagated};

struct ObjectSummary {
  std::uint16_t class_id = 0;
  int frames = 0;
  std::array<int, kWithPose.size()> frames_by_status{};
  int moving_frames = 0;
  Eigen::Vector3d first_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d last_m = Eigen::Vector3d::Zero();
  double speed_sum_mps = 0.0;  ///< Over the frames in which it moves; in others the speed may not have been measured.
  std::optional<double> nearest_m;  ///< Minimum distance to the camera; none if the camera had no pose in these frames.

  /// Stereo alone gives positions, and a speed of moving objects at most.
  [[nodiscard]] bool moved() const { return moving_frames > 0; }
  [[nodiscard]] bool is_motion_known() const { return moved() || frames_by_status[0] > 0; }
  [[nodiscard]] double displacement_m() const { return (last_m - first_m).norm(); }
  [[nodiscard]] double mean_speed_mps() const { return speed_sum_mps / moving_frames; }
};

struct RunTable {
  recording::FoundSummary found;
  bool looked_for = true;
  std::map<std::uint32_t, ObjectSummary> objects;
};

void add_row(const ObjectRow& row, const Eigen::Vector3d* camera_m, RunTable& table) {
  const auto* const status = std::find(kWithPose.begin(), kWithPose.end(), row.status);
  if (status == kWithPose.end()) {
    return;
  }
  const Eigen::Vector3d& position_m = row.T_world_obj.translation;
  ObjectSummary& object = table.objects[row.track_id];
  if (object.frames == 0) {
    object.first_m = position_m;
  }
  object.class_id = row.class_id;
  ++object.frames;
  ++object.frames_by_status[static_cast<std::size_t>(status - kWithPose.begin())];
  if (row.moving) {
    ++object.moving_frames;
    object.speed_sum_mps += row.velocity_mps.norm();
  }
  object.last_m = position_m;
  if (camera_m != nullptr) {
    const double distance_m = (position_m - *camera_m).norm();
    object.nearest_m = std::min(object.nearest_m.value_or(distance_m), distance_m);
  }
}

bool looked_for_objects(const std::string& config_json) {
  const Json config = Json::parse(config_json, nullptr, false);
  const Json::json_pointer mode("/segmentation/mode");
  return !config.is_object() || !config.contains(mode) || config.at(mode) != "none";
}

RunTable table_of(const Run& run) {
  RunTable table;
  RunTally tally;
  std::map<std::int64_t, const Eigen::Vector3d*> cameras_m;  // By time.
  for (const recording::CameraRow& row : run.camera) {
    tally.add_camera(row.T_world_cam.translation);
    cameras_m.emplace(row.timestamp_ns, &row.T_world_cam.translation);
  }
  for (const ObjectRow& row : run.objects) {
    tally.add_object(row.track_id, row.status, row.moving);
    const auto camera = cameras_m.find(row.timestamp_ns);
    add_row(row, camera == cameras_m.end() ? nullptr : camera->second, table);
  }
  table.found = tally.found();
  table.looked_for = looked_for_objects(run.config_json);
  return table;
}

std::string statuses_text(const ObjectSummary& object) {
  std::string text;
  for (std::size_t i = 0; i < kWithPose.size(); ++i) {
    if (const int frames = object.frames_by_status[i]; frames > 0) {
      text += (text.empty() ? "" : ", ") + std::string(to_string(kWithPose[i])) + " " + std::to_string(frames);
    }
  }
  return text;
}

void print_about(const Run& run) {
  for (const std::string& warning : run.warnings) {
    std::printf("Warning of the run: %s\n", printable(warning).c_str());
  }
  if (run.rectified.width_px > 0) {
    std::printf("Rectified: %s\n", geometry_text(run.rectified).c_str());
  }
}

void print_table(const RunTable& table) {
  std::printf("Found: %s\n", found_text(table.found, table.looked_for).c_str());
  if (table.objects.empty()) {
    return;
  }
  std::printf("%6s  %-12s %6s  %5s %8s %8s %8s  %s\n", "object", "class", "frames", "moved", "by m", "m/s", "near m",
              "frames by status");
  for (const auto& [id, object] : table.objects) {
    const auto number = [](double value, const char* format) {
      std::array<char, 32> text{};
      std::snprintf(text.data(), text.size(), format, value);
      return std::string(text.data());
    };
    const std::string none = object.is_motion_known() ? "-" : "?";
    std::printf("%6u  %-12s %6d  %5s %8s %8s %8s  %s\n", id, ClassName(object.class_id).c_str(), object.frames,
                object.moved()             ? "yes"
                : object.is_motion_known() ? "no"
                                           : "?",
                (object.moved() ? number(object.displacement_m(), "%.2f") : none).c_str(),
                (object.moved() ? number(object.mean_speed_mps(), "%.2f") : none).c_str(),
                (object.nearest_m ? number(*object.nearest_m, "%.1f") : "?").c_str(), statuses_text(object).c_str());
  }
  std::printf(
      "moved: its speed differed significantly from zero (?: never tracked, its speed was not measured); by: from the "
      "first to the last position; m/s: mean speed while it moved; near: closest to the camera\n");
}

void print_json(const RunTable& table, const Run& run) {
  Json objects = Json::array();
  for (const auto& [id, object] : table.objects) {
    Json by_status = Json::object();
    for (std::size_t i = 0; i < kWithPose.size(); ++i) {
      by_status[std::string(to_string(kWithPose[i]))] = object.frames_by_status[i];
    }
    objects.push_back({{"track_id", id},
                       {"class", ClassName(object.class_id).view()},
                       {"frames", object.frames},
                       {"frames_by_status", std::move(by_status)},
                       {"moved", object.is_motion_known() ? Json(object.moved()) : Json(nullptr)},
                       {"displacement_m", object.moved() ? Json(object.displacement_m()) : Json(nullptr)},
                       {"mean_speed_mps", object.moved() ? Json(object.mean_speed_mps()) : Json(nullptr)},
                       {"nearest_m", object.nearest_m ? Json(*object.nearest_m) : Json(nullptr)}});
  }
  const Json json{{"camera", {{"poses", table.found.poses}, {"path_m", table.found.camera_path_m}}},
                  {"objects_looked_for", table.looked_for},
                  {"objects", std::move(objects)},
                  {"baseline_m", run.rectified.width_px > 0 ? Json(run.rectified.baseline_m) : Json(nullptr)},
                  {"warnings", run.warnings}};
  std::printf("%s\n", json.dump(2).c_str());
}

int summary_command(const SummaryOptions& options) {
  const Result<Run> run = recording::read_run(options.run);
  if (!run) {
    return report(to_failure(run.error()));
  }
  for (const std::string& note : run->notes) {
    print_warning(note);
  }
  const RunTable table = table_of(*run);
  if (options.json) {
    print_json(table, *run);
    return 0;
  }
  print_about(*run);
  print_table(table);
  return 0;
}

void add_options(CLI::App& summary, SummaryOptions& options) {
  summary.add_option("RUN", options.run, "Run folder")->required();
  summary.add_flag("--json", options.json, "Prints the same as JSON");
}

}  // namespace

Action add_summary(CLI::App& command) {
  return bind_options(command, add_options, summary_command);
}

}  // namespace kinetrace::app

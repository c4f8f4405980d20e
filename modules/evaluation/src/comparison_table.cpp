#include <array>
#include <cstdio>
#include <optional>

#include "kinetrace/evaluation/evaluation.hpp"
#include "shares.hpp"

namespace kinetrace::evaluation {
namespace {

/// A figure of both runs, this run first.
struct Row {
  const char* name;
  const char* unit;
  std::optional<double> value;
  std::optional<double> against;
};

std::optional<double> count(std::size_t value) {
  return static_cast<double>(value);
}

std::vector<Row> camera_rows(const CameraMetrics& run, const CameraMetrics& against) {
  return {{"camera t_rel", "%", run.t_rel_percent, against.t_rel_percent},
          {"camera r_rel", "deg/m", run.r_rel_deg_per_m, against.r_rel_deg_per_m},
          {"camera ATE, SE(3)", "m", run.ate_m.se3.rmse(), against.ate_m.se3.rmse()},
          {"camera RPE", "m", run.rpe_translation_m.mean(), against.rpe_translation_m.mean()}};
}

std::vector<Row> object_rows(const ObjectMetrics& run, const ObjectMetrics& against) {
  const ObjectErrors& a = run.all;
  const ObjectErrors& b = against.all;
  return {
      {"coverage", "%", percent(a.covered_frames, a.tall_frames), percent(b.covered_frames, b.tall_frames)},
      {"id switches", "", count(a.id_switches), count(b.id_switches)},
      {"fragmentations", "", count(a.fragmentations), count(b.fragmentations)},
      {"seen to move", "%", percent(a.found_moving_rows, a.moving_rows), percent(b.found_moving_rows, b.moving_rows)},
      {"people seen to move", "%", percent(a.found_walking_rows, a.walking_rows),
       percent(b.found_walking_rows, b.walking_rows)},
      {"false moving tracks", "", count(run.false_moving.size()), count(against.false_moving.size())},
      {"motion per frame", "m", a.motion.translation_m.mean(), b.motion.translation_m.mean()},
      {"motion per frame", "deg", a.motion.rotation_deg.mean(), b.motion.rotation_deg.mean()},
      {"motions missing", "", count(a.missing_motions), count(b.missing_motions)},
      {"distance from trajectory", "m", a.distance_m.mean(), b.distance_m.mean()},
      {"centre of the box", "m", a.center_m.mean(), b.center_m.mean()},
      {"centre of moving people", "m", a.walking_distance_m.mean(), b.walking_distance_m.mean()},
      {"speed", "m/s", a.speed_mps.mean(), b.speed_mps.mean()},
      {"heading", "deg", a.heading_deg.mean(), b.heading_deg.mean()}};
}

std::string text_of(const std::optional<double>& value) {
  std::array<char, 32> text{"none"};
  if (value) {
    std::snprintf(text.data(), text.size(), "%.4g", *value);
  }
  return text.data();
}

std::string line_of(const Row& row) {
  const std::optional<double> ratio =
      row.value && row.against && *row.against > 0.0 ? std::optional(*row.value / *row.against) : std::nullopt;
  std::array<char, 32> ratio_text{""};
  if (ratio) {
    std::snprintf(ratio_text.data(), ratio_text.size(), "%.2f", *ratio);
  }
  std::array<char, 160> line{};
  std::snprintf(line.data(), line.size(), "  %-26s %12s %12s %8s  %s", row.name, text_of(row.value).c_str(),
                text_of(row.against).c_str(), ratio_text.data(), row.unit);
  std::string text = line.data();
  return text.substr(0, text.find_last_not_of(' ') + 1) + "\n";
}

}  // namespace

std::string comparison_table(const Evaluation& run, const Evaluation& against) {
  std::vector<Row> rows = camera_rows(run.camera, against.camera);
  if (run.objects && against.objects) {
    const std::vector<Row> of_objects = object_rows(*run.objects, *against.objects);
    rows.insert(rows.end(), of_objects.begin(), of_objects.end());
  }
  std::string text = "Run:     " + run.run + "\nAgainst: " + against.run + "\nTruth:   " + run.truth + "\n";
  std::array<char, 80> header{};
  std::snprintf(header.data(), header.size(), "  %-26s %12s %12s %8s\n", "", "run", "against", "ratio");
  text += header.data();
  for (const Row& row : rows) {
    text += line_of(row);
  }
  return text;
}

}  // namespace kinetrace::evaluation

#include "run_json.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include <nlohmann/json.hpp>

namespace kinetrace::recording {
namespace {

using Json = nlohmann::ordered_json;

Json timing_json(const TimingSummary& timing) {
  return {{"median", timing.median_ms}, {"p95", timing.p95_ms}, {"max", timing.max_ms}};
}

Json counters_json(const RunSummary& summary) {
  Json counters = Json::object();
  for (const auto& [name, member] : kFrameCounterNames) {
    counters[std::string(name)] = summary.counters.*member;
  }
  for (const auto& [name, value] : summary.camera_counters) {
    counters[name] = value;
  }
  return counters;
}

Json health_json(const HealthSummary& health) {
  Json reasons = Json::array();
  for (const HealthEntry& entry : health.entries) {
    reasons.push_back({{"reason", to_string(entry.reason)},
                       {"count", entry.count},
                       {"first_frame", entry.first_frame},
                       {"last_frame", entry.last_frame}});
  }
  return {{"state", to_string(health.state)},
          {"worst", to_string(health.worst)},
          {"camera", health.camera},
          {"reasons", std::move(reasons)}};
}

Json latency_json(const LatencySummary& latency) {
  if (latency.count == 0) {
    return nullptr;
  }
  return {{"count", latency.count},
          {"p50", latency.p50_ms},
          {"p95", latency.p95_ms},
          {"p99", latency.p99_ms},
          {"max", latency.max_ms}};
}

Json live_json(const LiveSummary& live) {
  return {{"deadline_ms", live.deadline_ms},
          {"frames_late", live.frames_late},
          {"frames_left_out", live.frames_left_out},
          {"shedding_level", live.level},
          {"worst_shedding_level", live.worst_level},
          {"latency_ms", latency_json(live.latency)},
          {"published_latency_ms", latency_json(live.published_latency)}};
}

Json geometry_json(const StereoGeometry& geometry) {
  return {{"width_px", geometry.width_px},    {"height_px", geometry.height_px}, {"fx_px", geometry.fx_px},
          {"fy_px", geometry.fy_px},          {"cx_px", geometry.cx_px},         {"cy_px", geometry.cy_px},
          {"baseline_m", geometry.baseline_m}};
}

Json correction_json(const RigCorrection::Vector& value_rad) {
  const RigCorrection::Vector deg = 180.0 / std::numbers::pi * value_rad;
  return {{"turn_deg", {deg[0], deg[1], deg[2]}},
          {"baseline_deg", {deg[3], deg[4]}},
          {"shift_deg", deg[RigCorrection::kShift]},
          {"focal_percent", 100.0 * value_rad[RigCorrection::kFocal]}};
}

Json rig_json(const RigEstimate& rig, const StereoGeometry& geometry) {
  Json depths = Json::array();
  for (const double depth_m : kReportedDepths_m) {
    const double error_m = depth_error_m(geometry, rig.correction, depth_m);
    depths.push_back({{"depth_m", depth_m}, {"error_m", std::isfinite(error_m) ? Json(error_m) : Json(nullptr)}});
  }
  return {{"verdict", to_string(rig.verdict)},
          {"estimate", correction_json(rig.correction.vector())},
          {"sigma", correction_json(rig.sigma_rad)},
          {"applied", correction_json(rig.applied.vector())},
          {"disparity_error_px", rig.correction.disparity_error_rad() * geometry.fx_px},
          {"disparity_sigma_px", rig.disparity_sigma_rad * geometry.fx_px},
          {"focal_known", rig.is_focal_known()},
          {"depth_errors", std::move(depths)},
          {"windows", rig.windows},
          {"knocks", rig.knocks}};
}

Json files_json(std::span<const FileEntry> files) {
  Json list = Json::array();
  for (const FileEntry& file : files) {
    list.push_back({{"path", file.path}, {"count", file.count}});
    if (file.rows) {
      list.back()["rows"] = *file.rows;
    }
  }
  return list;
}

/// Null if not counted.
void add_allocations(const RunSummary& summary, Json& run) {
  run["allocations_after_start"] = nullptr;
  run["foreign_allocations_after_start"] = nullptr;
  if (summary.allocations_after_start) {
    run["allocations_after_start"] = summary.allocations_after_start->own;
    run["foreign_allocations_after_start"] = summary.allocations_after_start->foreign;
  }
  run["foreign_allocations_per_frame_max"] = Json::object();
  for (const auto& [stage, count] : summary.stage_foreign_allocations) {
    run["foreign_allocations_per_frame_max"][stage] = count;
  }
}

}  // namespace

Result<std::string> run_json_text(const RunSummary& summary, const StereoGeometry& geometry,
                                  std::span<const FileEntry> files, std::uint64_t stray_points) {
  Json config = summary.config_json.empty() ? Json::object() : Json::parse(summary.config_json, nullptr, false);
  if (!config.is_object()) {
    return fail(ErrorCode::kInvalidArgument, "cannot write run.json: the configuration handed over is no JSON object");
  }
  Json run;
  run["version"] = summary.version;
  run["exit_status"] = summary.exit_status;
  run["dataset"] = Json::object();
  for (const auto& [name, value] : summary.dataset) {
    run["dataset"][name] = value;
  }
  run["config"] = std::move(config);
  run["rectified"] = geometry_json(geometry);
  run["frames"] = summary.frames;
  run["frame_ms"] = timing_json(summary.frame_time);
  run["stage_ms"] = Json::object();
  for (const auto& [stage, timing] : summary.stage_times) {
    run["stage_ms"][stage] = timing_json(timing);
  }
  run["rss_peak_bytes"] = summary.rss_peak_bytes;
  run["planned_bytes"] = summary.planned_bytes;
  run["budget_bytes"] = summary.budget_bytes;
  run["found"] = {{"camera_path_m", summary.found.camera_path_m},
                  {"objects", summary.found.objects},
                  {"objects_moved", summary.found.objects_moved}};
  add_allocations(summary, run);
  run["counters"] = counters_json(summary);
  run["health"] = health_json(summary.health);
  if (summary.rig) {
    run["calibration"] = rig_json(*summary.rig, geometry);
  }
  if (summary.pairing) {
    run["pairing"] = {{"offset_ms", summary.pairing->offset_ms},
                      {"drift_ppm", summary.pairing->drift_ppm},
                      {"relearned", summary.pairing->relearned}};
  }
  if (summary.live) {
    run["live"] = live_json(*summary.live);
  }
  run["warnings"] = summary.warnings;
  run["stray_points"] = stray_points;
  run["files"] = files_json(files);
  return run.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace kinetrace::recording

// Summary of a run, written to run.json.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kinetrace/core/allocation_counter.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/health.hpp"
#include "kinetrace/recording/latency_histogram.hpp"

namespace kinetrace::recording {

struct HealthSummary {
  HealthState state = HealthState::kOk;  ///< At the end.
  HealthState worst = HealthState::kOk;
  std::string camera;  ///< State of the camera at the end; empty: unknown.
  std::vector<HealthEntry> entries;
};

/// Pairing of two cameras' images.
struct PairingSummary {
  double offset_ms = 0.0;       ///< Delay of right images after left ones.
  double drift_ppm = 0.0;       ///< Rate of change of the offset.
  std::uint64_t relearned = 0;  ///< Number of times that the offset was learnt anew.
};

/// Summary of live mode.
struct LiveSummary {
  double deadline_ms = 0.0;           ///< For processing a frame.
  std::uint64_t frames_late = 0;      ///< Frames above the deadline.
  std::uint64_t frames_left_out = 0;  ///< Frames replaced by a newer one before processing.
  int level = 0;                      ///< Level of load shedding at the end; 0: none.
  int worst_level = 0;
  LatencySummary latency;              ///< From mid-exposure until a result was recorded and handed to the publisher.
  LatencySummary published_latency{};  ///< ... and until it was sent, if published.
};

/// Results, from final estimates.
struct FoundSummary {
  std::uint64_t poses = 0;          ///< Of the camera.
  double camera_path_m = 0.0;       ///< Sum of the distances between poses.
  std::uint64_t objects = 0;        ///< Objects with a pose.
  std::uint64_t objects_moved = 0;  ///< Of these: whose speed differed significantly from zero.
};

/// Filled by the application after the last frame, when it may allocate again.
struct RunSummary {
  std::string version;
  std::string config_json;  ///< The effective configuration as a JSON object; empty = {}.
  std::vector<std::pair<std::string, std::string>> dataset;  ///< Description: layout, path, sequence, cameras...
  std::int64_t frames = 0;                                   ///< Frames processed.
  TimingSummary frame_time;
  std::vector<std::pair<std::string, TimingSummary>> stage_times;
  /// Maximum of the libraries' allocations in one frame, by stage; empty if not counted.
  std::vector<std::pair<std::string, std::uint64_t>> stage_foreign_allocations;
  std::uint64_t rss_peak_bytes = 0;
  std::uint64_t planned_bytes = 0;  ///< Total of the memory plan.
  std::uint64_t budget_bytes = 0;   ///< The budget; without one, the planned total.
  FoundSummary found;
  std::optional<AllocationCounts> allocations_after_start;  ///< Absent if not counted.
  FrameCounters counters;
  std::vector<std::pair<std::string, std::uint64_t>> camera_counters;  ///< Added to the counters by name.
  HealthSummary health;
  std::optional<RigEstimate> rig;         ///< Present if the calibration was refined or checked.
  std::optional<PairingSummary> pairing;  ///< Of live cameras.
  std::optional<LiveSummary> live;        ///< Of live mode.
  std::vector<std::string> warnings;
  int exit_status = 0;  ///< Exit status of the program.
};

}  // namespace kinetrace::recording

// What a run has to say about itself; becomes run.json.
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

/// How two cameras' images were paired.
struct PairingSummary {
  double offset_ms = 0.0;       ///< What right images are later than left ones.
  double drift_ppm = 0.0;       ///< How fast that grows.
  std::uint64_t relearned = 0;  ///< Times that the offset had to be learnt anew.
};

/// How live mode went.
struct LiveSummary {
  double deadline_ms = 0.0;           ///< For processing a frame.
  std::uint64_t frames_late = 0;      ///< That took longer.
  std::uint64_t frames_left_out = 0;  ///< Since a newer one was there when processing had time for one.
  int level = 0;                      ///< Of shedding, at the end: 0 is none.
  int worst_level = 0;
  LatencySummary latency;              ///< From mid-exposure until a result was recorded and handed to the publisher.
  LatencySummary published_latency{};  ///< ... and until it was with the network, where it was published.
};

/// What was found, by final estimates.
struct FoundSummary {
  std::uint64_t poses = 0;          ///< Of the camera.
  double camera_path_m = 0.0;       ///< From pose to pose.
  std::uint64_t objects = 0;        ///< That had a pose.
  std::uint64_t objects_moved = 0;  ///< Of these: whose speed differed significantly from zero.
};

/// Filled in by the application after the last frame, when allocation is allowed again.
struct RunSummary {
  std::string version;
  std::string config_json;  ///< The effective configuration as a JSON object; empty = {}.
  std::vector<std::pair<std::string, std::string>> dataset;  ///< Description: layout, path, sequence, cameras...
  std::int64_t frames = 0;                                   ///< Frames processed.
  TimingSummary frame_time;
  std::vector<std::pair<std::string, TimingSummary>> stage_times;
  /// The most that libraries allocated in one frame, by stage; empty when the program does not count.
  std::vector<std::pair<std::string, std::uint64_t>> stage_foreign_allocations;
  std::uint64_t rss_peak_bytes = 0;
  std::uint64_t planned_bytes = 0;  ///< What all parts may take together.
  std::uint64_t budget_bytes = 0;   ///< What they were allowed to; without a budget, what was planned.
  FoundSummary found;
  std::optional<AllocationCounts> allocations_after_start;  ///< Absent when the program does not count.
  FrameCounters counters;
  std::vector<std::pair<std::string, std::uint64_t>> camera_counters;  ///< Added to the counters under their names.
  HealthSummary health;
  std::optional<RigEstimate> rig;         ///< Where the calibration was refined or checked.
  std::optional<PairingSummary> pairing;  ///< Of live cameras.
  std::optional<LiveSummary> live;        ///< Of live mode.
  std::vector<std::string> warnings;
  int exit_status = 0;  ///< Of the program, as the shell will see it.
};

}  // namespace kinetrace::recording

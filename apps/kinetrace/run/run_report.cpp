#include "run/run_report.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>

#include "camera/rig_report.hpp"
#include "cli/exit_codes.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "cli/printable.hpp"
#include "plan/memory.hpp"

namespace kinetrace::app {

std::string raw_stopped(const Error& why) {
  return "raw recording stopped: " + why.message;
}

RunReport::RunReport(const RunOptions& options, const CameraSetup& setup, const pipeline::PipelineConfig& config,
                     std::string config_json)
    : options_(options),
      looks_for_objects_(config.segmentation.mode != segmentation::SegmentationMode::kNone),
      calibration_mode_(config.calibration.mode) {
  summary_.version = KINETRACE_VERSION;
  summary_.config_json = std::move(config_json);
  summary_.dataset = setup.description;
  summary_.warnings = setup.notes;
}

void RunReport::set_memory(const RunMemory& plan, const pipeline::MemoryConfig& config) {
  summary_.planned_bytes = plan.total_bytes();
  summary_.budget_bytes = static_cast<std::uint64_t>(budget_bytes(plan, config));
}

void RunReport::start() {
  start_ = std::chrono::steady_clock::now();
  allocations_at_start_ = allocation_counts();
}

void RunReport::warn_now(const std::string& warning) {
  print_warning(warning);
  const std::lock_guard lock(*mutex_);
  summary_.warnings.push_back(warning);
  reported_.push_back(warning);
}

bool RunReport::was_reported(const std::string& warning) const {
  return std::find(reported_.begin(), reported_.end(), warning) != reported_.end();
}

void RunReport::add_warnings(const GuardedCamera& camera) {
  if (camera.file != nullptr) {
    summary_.warnings.insert(summary_.warnings.end(), camera.file->warnings().begin(), camera.file->warnings().end());
  }
  const hal::CameraCounters& skipped = camera.camera->counters();
  if (skipped.skipped_missing_side + skipped.skipped_unreadable > 0) {
    summary_.warnings.push_back("skipped " + std::to_string(skipped.skipped_missing_side) +
                                " frames with a missing side and " + std::to_string(skipped.skipped_unreadable) +
                                " that cannot be read");
  }
}

void RunReport::add_health() {
  summary_.health = {.state = health.state(),
                     .worst = health.worst(),
                     .camera = std::string(to_string(health.camera())),
                     .entries = health.entries()};
  if (health.worst() != HealthState::kOk) {
    std::string reasons;
    for (const HealthEntry& entry : summary_.health.entries) {
      reasons += (reasons.empty() ? "" : ", ") + std::string(to_string(entry.reason)) + " " +
                 std::to_string(entry.count) + "x since " +
                 (entry.first_frame < 0 ? "the start" : "frame " + std::to_string(entry.first_frame));
    }
    summary_.warnings.push_back("was " + std::string(to_string(health.worst())) + ": " + reasons);
  }
  const auto lost = static_cast<std::int64_t>(health.all()[static_cast<std::size_t>(HealthReason::kPoseLost)].count);
  if (2 * lost > summary_.frames) {
    summary_.warnings.push_back("the camera's motion was found in " + std::to_string(summary_.frames - lost) + " of " +
                                std::to_string(summary_.frames) +
                                " frames only, so these results are of no use; check the light and that the images of "
                                "both views and the calibration belong together (kinetrace doctor)");
  }
}

void RunReport::add_masks(const MaskCounters& masks) {
  for (const auto& [name, count] : {std::pair<const char*, std::uint64_t>{"mask_frames_taken", masks.frames_taken},
                                    {"mask_frames_timed_out", masks.frames_timed_out},
                                    {"mask_frames_without_sender", masks.frames_unsent},
                                    {"mask_messages", masks.messages},
                                    {"mask_messages_late", masks.messages_late},
                                    {"mask_messages_early", masks.messages_early},
                                    {"mask_messages_of_other_run", masks.messages_of_other_run},
                                    {"mask_messages_invalid", masks.messages_invalid}}) {
    summary_.camera_counters.emplace_back(name, count);
  }
  if (masks.frames_timed_out + masks.frames_unsent > 0) {
    summary_.warnings.push_back(
        "tracks were propagated without masks in " + std::to_string(masks.frames_timed_out + masks.frames_unsent) +
        " frames: " + std::to_string(masks.frames_timed_out) + " waited in vain (segmentation.dds.timeout_ms), in " +
        std::to_string(masks.frames_unsent) + " without a sender");
  }
  for (const auto& [count, why] :
       {std::pair{masks.messages_of_other_run, kMasksOfOtherRun}, std::pair{masks.messages_invalid, kMasksInvalid}}) {
    if (count > 0) {
      summary_.warnings.push_back(std::to_string(count) + " messages with masks were refused: " + std::string(why));
    }
  }
}

void RunReport::add_network(const NetworkThread& network) {
  const NetworkThreadCounters counters = network.counters();
  constexpr double kMicroseconds = 1e3;
  for (const auto& [name, count] :
       {std::pair<const char*, std::uint64_t>{"network_frames", counters.frames},
        {"network_frames_failed", counters.failed},
        {"network_median_us", static_cast<std::uint64_t>(counters.median_ms * kMicroseconds)},
        {"network_longest_us", static_cast<std::uint64_t>(counters.longest_ms * kMicroseconds)},
        {"network_bytes", network.bytes()}}) {
    summary_.camera_counters.emplace_back(name, count);
  }
  if (counters.failed > 0) {
    summary_.warnings.push_back("the neural network failed in " + std::to_string(counters.failed) +
                                " frames, whose tracks were propagated: " + network.first_error());
  }
}

void RunReport::add_raw(const RecordingThread& raw) {
  summary_.camera_counters.emplace_back("raw_frames_recorded", static_cast<std::uint64_t>(raw.written()));
  summary_.camera_counters.emplace_back("raw_frames_dropped", raw.dropped());
  if (const std::optional<Error> failure = raw.stopped_by(); failure && !was_reported(raw_stopped(*failure))) {
    summary_.warnings.push_back(raw_stopped(*failure));
  }
}

void RunReport::add_published(const RunPublishing& published) {
  for (auto& counter : published.counters()) {
    summary_.camera_counters.push_back(std::move(counter));
  }
  if (summary_.live) {
    summary_.live->published_latency = published.latency();
  }
}

void RunReport::finish(const GuardedCamera& camera, const Processed& processed, const StageClock& capture_clock,
                       const StageClock& clock, const Status& played) {
  seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  summary_.frames = processed.frames;
  summary_.counters = processed.counters;
  if (calibration_mode_ != rig::RefineMode::kOff) {
    summary_.rig = processed.rig;
    if (processed.rig.verdict == RigVerdict::kOff) {
      // Focal lengths are corrected by no mode.
      const char* remedy = calibration_mode_ == rig::RefineMode::kCheck
                               ? "; calibrate again, set calibration.refine: on, or start with what "
                               : "; calibrate again, or start with what ";
      summary_.warnings.push_back("the calibration is " + rig_text(processed.rig, geometry_) + remedy +
                                  "--save-calibration writes");
    }
  }
  const hal::CameraCounters& counted = camera.camera->counters();
  summary_.camera_counters = {{"frames_skipped_missing_side", counted.skipped_missing_side},
                              {"frames_skipped_unreadable", counted.skipped_unreadable},
                              {"frames_skipped_outdated", counted.skipped_outdated},
                              {"frames_skipped_repeated", counted.skipped_repeated},
                              {"frames_skipped_wrong_size", counted.skipped_wrong_size},
                              {"frames_missing_in_numbering", counted.gaps},
                              {"camera_clock_jumps", counted.clock_jumps},
                              {"camera_pairing_slips", counted.pairing_slips},
                              {"camera_pairing_moves", counted.pairing_moves},
                              {"camera_stream_restarts", counted.stream_restarts},
                              {"camera_stalls", counted.stalls},
                              {"camera_losses", counted.losses},
                              {"camera_recoveries", counted.recoveries}};
  summary_.frame_time = clock.frame_time();
  summary_.stage_times = clock.stage_times();
  const auto captured = capture_clock.stage_times();
  constexpr auto kOfCapture = static_cast<std::size_t>(Stage::kPyramid);
  std::copy_n(captured.begin(), kOfCapture, summary_.stage_times.begin());
  summary_.rss_peak_bytes = peak_rss_bytes();
  summary_.found = tally_.found();
  if (allocation_counting_available()) {
    summary_.allocations_after_start = AllocationCounts{processed.allocations.own - allocations_at_start_.own,
                                                        processed.allocations.foreign - allocations_at_start_.foreign};
    summary_.stage_foreign_allocations = clock.foreign_allocations();
    const auto while_capturing = capture_clock.foreign_allocations();
    std::copy_n(while_capturing.begin(), kOfCapture, summary_.stage_foreign_allocations.begin());
  }
  if (camera.live != nullptr) {
    const hal::PairingStatus pairing = camera.live->pairing();
    summary_.pairing = {pairing.offset_ms, pairing.drift_ppm, pairing.relearned};
  }
  add_warnings(camera);
  add_health();
  if (!played) {
    summary_.warnings.push_back("ended early: " + played.error().message);
    summary_.exit_status = static_cast<int>(exit_code(played.error().code));
  } else if (interrupted_by() != 0) {
    summary_.warnings.push_back("ended early by signal " + std::to_string(interrupted_by()));
    summary_.exit_status = kSignalBase + interrupted_by();
  }
}

void RunReport::print_warnings() const {
  for (const std::string& warning : summary_.warnings) {
    if (!was_reported(warning)) {
      print_warning(warning);
    }
  }
}

void RunReport::print() const {
  print_warnings();
  if (options_.json) {
    std::cout << std::ifstream(options_.out / "run.json").rdbuf();
  } else if (!options_.quiet) {
    constexpr double kMib = 1024.0 * 1024.0;
    std::printf(
        "%lld frames in %.1f s; %.1f ms a frame (p95 %.1f, max %.1f) without decoding; peak memory %.1f MiB, "
        "planned %.1f\n",
        static_cast<long long>(summary_.frames), seconds_, summary_.frame_time.median_ms, summary_.frame_time.p95_ms,
        summary_.frame_time.max_ms, static_cast<double>(summary_.rss_peak_bytes) / kMib,
        static_cast<double>(summary_.planned_bytes) / kMib);
    std::printf("Rectified: %s\n", geometry_text(geometry_).c_str());
    std::printf("Found: %s\n", found_text(summary_.found, looks_for_objects_).c_str());
    if (summary_.rig) {
      std::printf("Calibration: %s\n", rig_text(*summary_.rig, geometry_).c_str());
    }
    std::printf("Results in %s\n", options_.out.c_str());
    for (const std::string& note : notes_) {
      std::printf("Note: %s\n", printable(note).c_str());
    }
  }
}

}  // namespace kinetrace::app

#include "run_report.hpp"

#include <cstdio>
#include <fstream>
#include <iostream>

#include "exit_codes.hpp"
#include "interrupt.hpp"
#include "memory.hpp"
#include "messages.hpp"

namespace kinetrace::app {

RunReport::RunReport(const RunOptions& options, const hal::Dataset& dataset, std::string config_json)
    : options_(options) {
  summary_.version = KINETRACE_VERSION;
  summary_.config_json = std::move(config_json);
  summary_.dataset = {{"dataset", options.dataset},
                      {"sequence", dataset.name},
                      {"calibration", dataset.calibration.source},
                      {"cameras", options.cameras.empty() ? "auto" : options.cameras}};
  summary_.warnings = dataset.notes;
}

void RunReport::start() {
  start_ = std::chrono::steady_clock::now();
  allocations_at_start_ = allocation_counts();
  allocations_at_last_frame = allocations_at_start_;
}

void RunReport::add_warnings(const hal::FileStereoCamera& camera) {
  summary_.warnings.insert(summary_.warnings.end(), camera.warnings().begin(), camera.warnings().end());
  const hal::CameraCounters& skipped = camera.counters();
  if (skipped.skipped_missing_side + skipped.skipped_unreadable > 0) {
    summary_.warnings.push_back("skipped " + std::to_string(skipped.skipped_missing_side) +
                                " frames with a missing side and " + std::to_string(skipped.skipped_unreadable) +
                                " that cannot be read");
  }
}

void RunReport::finish(const hal::FileStereoCamera& camera, const StageClock& clock, const Status& played) {
  seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  summary_.frames = frames;
  summary_.counters = counters;
  summary_.camera_counters = {{"frames_skipped_missing_side", camera.counters().skipped_missing_side},
                              {"frames_skipped_unreadable", camera.counters().skipped_unreadable},
                              {"frames_missing_in_numbering", camera.counters().gaps}};
  summary_.frame_time = clock.frame_time();
  summary_.stage_times = clock.stage_times();
  summary_.rss_peak_bytes = peak_rss_bytes();
  if (allocation_counting_available()) {
    summary_.allocations_after_start =
        AllocationCounts{allocations_at_last_frame.own - allocations_at_start_.own,
                         allocations_at_last_frame.foreign - allocations_at_start_.foreign};
  }
  add_warnings(camera);
  if (!played) {
    summary_.warnings.push_back("ended early: " + played.error().message);
    summary_.exit_status = static_cast<int>(exit_code(played.error().code));
  } else if (interrupted_by() != 0) {
    summary_.warnings.push_back("ended early by signal " + std::to_string(interrupted_by()));
    summary_.exit_status = kSignalBase + interrupted_by();
  }
}

void RunReport::print() const {
  for (const std::string& warning : summary_.warnings) {
    print_warning(warning);
  }
  if (options_.json) {
    std::cout << std::ifstream(options_.out / "run.json").rdbuf();
  } else if (!options_.quiet) {
    std::printf("%lld frames in %.1f s; %.1f ms a frame (p95 %.1f, max %.1f) without decoding; peak memory %.1f MiB\n",
                static_cast<long long>(frames), seconds_, summary_.frame_time.median_ms, summary_.frame_time.p95_ms,
                summary_.frame_time.max_ms, static_cast<double>(summary_.rss_peak_bytes) / (1024.0 * 1024.0));
    std::printf("Results in %s\n", options_.out.c_str());
  }
}

}  // namespace kinetrace::app

#include "plan/memory.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string_view>
#include <unistd.h>
#include <utility>

#include "camera/recording_thread.hpp"
#include "kinetrace/hal/input_monitor.hpp"
#include "kinetrace/pipeline/pipeline.hpp"
#include "live/live_run.hpp"
#include "live/thread_stacks.hpp"

namespace kinetrace::app {
namespace {

constexpr double kMib = 1024.0 * 1024.0;

std::string mib(double bytes) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f MiB", bytes / kMib);
  return text.data();
}

// The run's threads, including the main thread; those of DDS are part of its participant's share.
int thread_count(const AppConfig& config, const CameraSetup& camera, const RawOutputOptions& raw,
                 const PublishingSetup* publishing) {
  const bool receives_masks = config.pipeline.segmentation.mode == segmentation::SegmentationMode::kDds;
  return 1 + (is_live(config.live, camera) ? 1 : 0) + (raw.out.empty() ? 0 : 1) + (publishing == nullptr ? 0 : 1) +
         (receives_masks ? 1 : 0) + config.processing.workers() - 1;
}

MemoryPlan plan_outside(const AppConfig& config, const CameraSetup& camera, const RawOutputOptions& raw,
                        const PublishingSetup* publishing, const NetworkThread* network) {
  MemoryPlan plan;
  plan.entries.push_back({"stacks",
                          kThreadStackBytes * static_cast<std::size_t>(thread_count(config, camera, raw, publishing)),
                          "live.mode, processing.threads, --record, --publish, segmentation.mode"});
  plan.entries.push_back(
      {"libraries", static_cast<std::size_t>(config.pipeline.memory.libraries_mib * kMib), "memory.libraries_mib"});
  if (publishing != nullptr) {
    plan.entries.push_back({"DDS participant", publishing->library_bytes(), "dds.security.mode"});
  }
  if (network != nullptr) {
    plan.entries.push_back({"neural network", network->bytes(), "segmentation.onnx.model, .threads; measured"});
  }
  return plan;
}

Status fits_the_machine(const RunMemory& plan) {
  const auto needed = static_cast<double>(plan.total_bytes());
  const double machine = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  return needed <= machine
             ? Status{}
             : fail(ErrorCode::kBudget, "the plan needs " + mib(needed) + ", and this machine has " + mib(machine) +
                                            "; `kinetrace plan` lists the memory of each part");
}

}  // namespace

recording::RecordingConfig recording_config(const AppConfig& config, const StereoGeometry& geometry,
                                            const std::filesystem::path& directory) {
  recording::RecordingConfig recording;
  recording.directory = directory;
  recording.geometry = geometry;
  recording.mots = config.output.mots;
  recording.observations = config.output.observations;
  recording.points = config.output.points;
  recording.colmap = config.output.colmap;
  return recording;
}

std::optional<MaskMailboxConfig> mask_mailbox_config(const AppConfig& config, const StereoGeometry& geometry) {
  const segmentation::SegmentationConfig& segmentation = config.pipeline.segmentation;
  if (segmentation.mode != segmentation::SegmentationMode::kDds) {
    return std::nullopt;
  }
  return MaskMailboxConfig{geometry.width_px, geometry.height_px, segmentation.dds.right,
                           std::chrono::milliseconds(segmentation.dds.timeout_ms)};
}

bool is_live(const LiveConfig& config, const CameraSetup& camera) noexcept {
  return config.mode == LiveMode::kOn || (config.mode == LiveMode::kAuto && camera.live);
}

Result<RunMemory> plan_memory(const AppConfig& config, const CameraSetup& camera, const RawOutputOptions& raw,
                              const PublishingSetup* publishing, const NetworkThread* network) {
  const auto geometry = hal::Rectifier::rectified_geometry(camera.calibration, config.rectification);
  if (!geometry) {
    return Unexpected(geometry.error());
  }
  const Result<MemoryPlan> processing = pipeline::Pipeline::plan(config.pipeline, *geometry);
  if (!processing) {
    return Unexpected(processing.error());
  }
  MemoryPlan plan;
  plan.entries.push_back({"camera", camera.required_bytes(), "image size, pixel format, largest image file"});
  plan.entries.push_back({"rectifier", hal::Rectifier::required_bytes(camera.calibration, config.rectification),
                          "image size; nothing for rectified recordings"});
  if (const std::optional<MaskMailboxConfig> masks = mask_mailbox_config(config, *geometry)) {
    plan.entries.push_back({"masks", MaskMailbox::required_bytes(*masks), "segmentation.dds.right"});
  }
  plan.entries.insert(plan.entries.end(), processing->entries.begin(), processing->entries.end());
  plan.entries.push_back(
      {"recorder", recording::RunRecorder::required_bytes(recording_config(config, *geometry, "")), "output.*"});
  plan.entries.push_back(
      {"input watch", hal::InputMonitor::required_bytes({}, geometry->width_px, geometry->height_px), "image size"});
  if (is_live(config.live, camera)) {
    plan.entries.push_back({"live frames", LiveRun::required_bytes(*geometry), "image size, live.mode"});
  }
  if (!raw.out.empty()) {
    plan.entries.push_back({"raw recording",
                            RecordingThread::required_bytes(raw_recorder_config(raw, camera.calibration, 1.0)),
                            "image size"});
  }
  if (publishing != nullptr) {
    plan.entries.push_back(publishing->plan());
  }
  // Each part begins at a multiple of the arena's alignment.
  for (MemoryPlanEntry& entry : plan.entries) {
    entry.bytes = (entry.bytes + Arena::kAlignment - 1) / Arena::kAlignment * Arena::kAlignment;
  }
  return RunMemory{std::move(plan), plan_outside(config, camera, raw, publishing, network)};
}

double budget_bytes(const RunMemory& plan, const pipeline::MemoryConfig& config) noexcept {
  return config.budget_mib > 0.0 ? config.budget_mib * kMib : static_cast<double>(plan.total_bytes());
}

Status check_budget(const RunMemory& plan, const pipeline::MemoryConfig& config) {
  const double budget = budget_bytes(plan, config);
  const auto needed = static_cast<double>(plan.total_bytes());
  if (needed <= budget) {
    return fits_the_machine(plan);
  }
  const auto& parts = plan.arena.entries;
  const auto largest =
      std::max_element(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.bytes < b.bytes; });
  return fail(ErrorCode::kBudget, "memory.budget_mib = " + mib(budget) + " is " + mib(needed - budget) +
                                      " too small: " + mib(static_cast<double>(plan.arena.total_bytes())) +
                                      " planned and " + mib(static_cast<double>(plan.outside.total_bytes())) +
                                      " for libraries and threads; raise it to " +
                                      mib(std::ceil(needed / kMib * 10.0) / 10.0 * kMib) + " or shrink \"" +
                                      largest->name + "\" (" + mib(static_cast<double>(largest->bytes)) + ", by " +
                                      largest->depends_on + "); `kinetrace plan` lists all");
}

std::uint64_t peak_rss_bytes() {
  std::ifstream status("/proc/self/status");
  constexpr std::string_view kKey = "VmHWM:";
  for (std::string line; std::getline(status, line);) {
    if (line.compare(0, kKey.size(), kKey) == 0) {
      std::uint64_t kib = 0;
      std::istringstream(line.substr(kKey.size())) >> kib;
      return kib * 1024;
    }
  }
  return 0;
}

}  // namespace kinetrace::app

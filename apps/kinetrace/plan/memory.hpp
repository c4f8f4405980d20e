// Who takes how much, before anybody takes it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "camera/camera_setup.hpp"
#include "config/app_config.hpp"
#include "dds/run_publishing.hpp"
#include "kinetrace/core/memory_plan.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/recording/run_recorder.hpp"
#include "segmentation/mask_mailbox.hpp"
#include "segmentation/network_thread.hpp"

namespace kinetrace::app {

/// Settings of the recorder for a run of `config` on images with `geometry`.
[[nodiscard]] recording::RecordingConfig recording_config(const AppConfig& config, const StereoGeometry& geometry,
                                                          const std::filesystem::path& directory);

/// Settings of the mailbox for masks from other processes; none unless segmentation.mode is dds.
[[nodiscard]] std::optional<MaskMailboxConfig> mask_mailbox_config(const AppConfig& config,
                                                                   const StereoGeometry& geometry);

/// Whether a run with this camera is live: the newest frame wins, and frames are left out when processing is too slow.
[[nodiscard]] bool is_live(const LiveConfig& config, const CameraSetup& camera) noexcept;

/// What a run takes at most.
struct RunMemory {
  MemoryPlan arena;    ///< In the order of creation; its total is the arena's size.
  MemoryPlan outside;  ///< What threads and libraries take from the system.

  [[nodiscard]] std::size_t total_bytes() const noexcept { return arena.total_bytes() + outside.total_bytes(); }
};

/// Everything that a run with this camera takes, with what it records, publishes and segments with, if any.
/// Errors: those of the parts (kInvalidConfig, kBadCalibration).
[[nodiscard]] Result<RunMemory> plan_memory(const AppConfig& config, const CameraSetup& camera,
                                            const RawOutputOptions& raw = {},
                                            const PublishingSetup* publishing = nullptr,
                                            const NetworkThread* network = nullptr);

/// memory.budget_mib; without one, what the plan needs.
[[nodiscard]] double budget_bytes(const RunMemory& plan, const pipeline::MemoryConfig& config) noexcept;

/// kBudget, with what is missing and which part is largest, if more is planned than memory.budget_mib,
/// or than the machine has.
[[nodiscard]] Status check_budget(const RunMemory& plan, const pipeline::MemoryConfig& config);

/// The largest resident set that the process had so far; 0 if the system does not tell.
[[nodiscard]] std::uint64_t peak_rss_bytes();

}  // namespace kinetrace::app

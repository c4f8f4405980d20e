// The memory plan of a run, made before any allocation.
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

/// Upper bound of a run's memory.
struct RunMemory {
  MemoryPlan arena;    ///< In the order of creation; its total is the arena's size.
  MemoryPlan outside;  ///< Memory of threads and libraries, outside the arena.

  [[nodiscard]] std::size_t total_bytes() const noexcept { return arena.total_bytes() + outside.total_bytes(); }
};

/// Memory of a run with this camera, including recording, publishing and the network, if any. Errors: those of the
/// parts (kInvalidConfig, kBadCalibration).
[[nodiscard]] Result<RunMemory> plan_memory(const AppConfig& config, const CameraSetup& camera,
                                            const RawOutputOptions& raw = {},
                                            const PublishingSetup* publishing = nullptr,
                                            const NetworkThread* network = nullptr);

/// memory.budget_mib; if unset, the plan's total.
[[nodiscard]] double budget_bytes(const RunMemory& plan, const pipeline::MemoryConfig& config) noexcept;

/// kBudget if the plan exceeds memory.budget_mib or the machine's memory; the message has the shortfall and the largest
/// part.
[[nodiscard]] Status check_budget(const RunMemory& plan, const pipeline::MemoryConfig& config);

/// Peak resident set of the process; 0 if unknown.
[[nodiscard]] std::uint64_t peak_rss_bytes();

}  // namespace kinetrace::app

// The two kinds of RawRecorder.
#pragma once

#include <memory>

#include "kinetrace/hal/raw_recorder.hpp"

namespace kinetrace::hal {

[[nodiscard]] std::size_t container_recorder_bytes(const RawRecorderConfig& config);
[[nodiscard]] Result<std::unique_ptr<RawRecorder>> make_container_recorder(const RawRecorderConfig& config,
                                                                           Arena& arena);
[[nodiscard]] Result<std::unique_ptr<RawRecorder>> make_kitti_recorder(const RawRecorderConfig& config);

/// kIo if fewer than `keep_free_bytes` would stay free on the disk of `folder` after `needed_bytes` more.
[[nodiscard]] Status check_space(const std::filesystem::path& folder, std::uint64_t keep_free_bytes,
                                 std::uint64_t needed_bytes);

}  // namespace kinetrace::hal

// Details available only in a run's models: names of images, gray values of points.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "kinetrace/core/result.hpp"
#include "kinetrace/recording/run_reader.hpp"

namespace kinetrace::batch {

// Errors of all: kIo, kBadFormat (no regular file).

/// Whether the files of the details can be opened, for refinements that read them at the end of long work.
[[nodiscard]] Status check_details(const recording::Run& run);
/// Stems by frame, from the background's COLMAP model; empty without one.
[[nodiscard]] Result<std::map<std::int64_t, std::string>> image_names(const recording::Run& run);
/// By point, from the body's point cloud; empty without one. `track_id` 0 is the background.
[[nodiscard]] Result<std::map<std::uint32_t, std::uint8_t>> point_intensities(const recording::Run& run,
                                                                              std::uint32_t track_id);

}  // namespace kinetrace::batch

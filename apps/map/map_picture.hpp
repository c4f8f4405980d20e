// A small map: paths and reference from above, north up.
#pragma once

#include <filesystem>
#include <span>

#include "kinetrace/geo/alignment.hpp"
#include "kinetrace/geo/map_files.hpp"
#include "kinetrace/geo/reference.hpp"

namespace kinetrace::map {

/// Fixes are drawn at the reference's positions; outliers are marked. Errors: kIo.
[[nodiscard]] Status write_map_picture(const std::filesystem::path& file,
                                       std::span<const geo::MapTrajectory> trajectories,
                                       const geo::Reference& reference, const geo::Alignment& alignment);

}  // namespace kinetrace::map

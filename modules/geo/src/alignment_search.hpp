// Initial transform and time offset, found globally and with outliers.
#pragma once

#include <optional>
#include <span>

#include "alignment_model.hpp"

namespace kinetrace::geo {

struct AlignmentStart {
  Se3 T_map_world;
  double time_offset_s = 0.0;
};

/// The best of all time offsets of the search; none if too few fixes match the path at any of them.
[[nodiscard]] std::optional<AlignmentStart> search_start(const AntennaPath& path, std::span<const Fix> fixes,
                                                         const AlignmentConfig& config);

/// Fewer do not determine seven unknowns, noise and outliers.
inline constexpr std::size_t kMinFixes = 10;

}  // namespace kinetrace::geo

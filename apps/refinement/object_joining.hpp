// Joins tracks of the same object.
#pragma once

#include <cstdint>
#include <map>

#include "object_refinement.hpp"

namespace kinetrace::batch {

/// Joins a track to one that ended before it began, where usual motion connects the end of the one with the beginning
/// of the other, and no other track fits nearly as well. The joined object keeps the earlier id and frame. Returns the
/// new id of each joined track.
[[nodiscard]] std::map<std::uint32_t, std::uint32_t> join_tracks(std::map<std::uint32_t, RefinedObject>& objects);

}  // namespace kinetrace::batch

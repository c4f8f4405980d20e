// Tracks that are one object, cut in two.
#pragma once

#include <cstdint>
#include <map>

#include "object_refinement.hpp"

namespace kinetrace::batch {

/// Joins a track that begins after another one has ended to it, where a path that things usually take leads from the
/// end of the one to the beginning of the other, and no other track does as well. The joined object keeps the earlier
/// id and frame. Returns by which id each track that is no more goes on.
[[nodiscard]] std::map<std::uint32_t, std::uint32_t> join_tracks(std::map<std::uint32_t, RefinedObject>& objects);

}  // namespace kinetrace::batch

// tracks/ID.tum from the finalised poses.
#pragma once

#include "spool.hpp"

namespace kinetrace::recording {

/// `poses` sorted by body and frame. One file per object.
[[nodiscard]] Status write_tracks(const Workspace& workspace, RunCounts& counts);

}  // namespace kinetrace::recording

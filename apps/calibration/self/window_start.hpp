// Initial values of a window's bundle adjustment: points from stereo, poses from points.
#pragma once

#include <optional>

#include "rig_bundle.hpp"
#include "track_window.hpp"

namespace kinetrace::self_calibration {

/// Poses chained from frame to frame by perspective-n-point with random samples (fixed seed), points from their first
/// left-right pair. Ends before a frame that finds too few points; empty where
/// fewer than three frames are left.
[[nodiscard]] std::optional<BundleWindow> start_window(const RigModel& rig, const TrackWindow& tracks);

}  // namespace kinetrace::self_calibration

// Bundle adjustment in rounds, with outlier rejection between them.
#pragma once

#include <vector>

#include "kinetrace/core/result.hpp"
#include "rig_bundle.hpp"

namespace kinetrace::self_calibration {

enum class RoundPlan {
  kFromAfar,  ///< The rig may be far off: few iterations a round.
  kFromNear,  ///< Poses and points first, then all, to convergence.
};

/// Improves rig and windows and marks points that are not used. Whole tracks are rejected: on a moving object or after
/// a tracking error, all observations are wrong. `options.sigma_px` becomes the scatter of a coordinate.
[[nodiscard]] Status adjust_in_rounds(RigModel& rig, std::vector<BundleWindow>& windows, RoundPlan plan,
                                      BundleOptions& options);

/// Fraction of the points that is used.
[[nodiscard]] double used_share(const std::vector<BundleWindow>& windows);

}  // namespace kinetrace::self_calibration

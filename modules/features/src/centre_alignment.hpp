// The last, exact step of every alignment.
#pragma once

#include <Eigen/Core>

#include "kernel_types.hpp"

namespace kinetrace::features {

/// Puts `position`, where `patch` was found in `image`, where the middle of the patch is. A patch that reaches over a
/// contour is found somewhere between where its two sides are, and where between them changes as the camera comes
/// nearer: depths are then off in common. Unchanged where the middle has too little texture. Narrows `patch`.
/// `options` as for aligning the whole patch.
void align_centre(const Plane& image, const AlignOptions& options, PatchTemplate& patch,
                  Eigen::Vector2f& position) noexcept;

}  // namespace kinetrace::features

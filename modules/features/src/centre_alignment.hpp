// The last step of every alignment.
#pragma once

#include <Eigen/Core>

#include "kernel_types.hpp"

namespace kinetrace::features {

/// Moves `position`, the match of `patch` in `image`, to the match of the patch's centre alone. A patch over a contour
/// matches between the positions of its two sides, by a part that changes as the camera approaches: a bias common to
/// all depths. Unchanged if the centre has too little texture. Narrows `patch`. `options` as for aligning the whole
/// patch.
void align_centre(const Plane& image, const AlignOptions& options, PatchTemplate& patch,
                  Eigen::Vector2f& position) noexcept;

}  // namespace kinetrace::features

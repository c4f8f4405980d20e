// Similarity of two places of an image.
#pragma once

#include <Eigen/Core>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace::segmentation {

/// Greatest zero-mean normalised correlation of the 11x11 patch at `a` with patches within two pixels of `b`; -1 when
/// either lies outside the image or has no texture.
[[nodiscard]] float patch_similarity(GrayView image, const Eigen::Vector2f& a, const Eigen::Vector2f& b) noexcept;

}  // namespace kinetrace::segmentation

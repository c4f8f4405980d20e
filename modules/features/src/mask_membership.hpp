// Whether a feature still belongs to its body, given the masks of the frame.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace::features {

/// Masks are a pixel or two off at their borders, so a feature keeps its body unless it lies `border_px` inside another
/// one. The ignore label ends it at once.
[[nodiscard]] bool still_member(LabelView labels, const Eigen::Vector2f& position_px, std::uint8_t body,
                                float border_px) noexcept;

/// False where a patch around an object's feature would hold too much of something else: along a contour a patch
/// follows whichever side is more textured. Of another object nothing may lie on any of its four sides; of the
/// background, which small objects are surrounded by, no more than on two.
[[nodiscard]] bool well_inside(LabelView labels, const Eigen::Vector2f& position_px, std::uint8_t body) noexcept;

}  // namespace kinetrace::features

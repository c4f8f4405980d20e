// Whether a feature still belongs to its body, given the masks of the frame.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "kernel_types.hpp"
#include "kinetrace/core/image_view.hpp"

namespace kinetrace::features {

/// Masks are a pixel or two off at their borders, so a feature keeps its body unless it lies `border_px` inside another
/// one. The ignore label ends it at once.
[[nodiscard]] bool still_member(LabelView labels, const Eigen::Vector2f& position_px, std::uint8_t body,
                                float border_px) noexcept;

/// False where a patch around an object's feature would hold much of another object: along their common contour a patch
/// follows whichever of the two is more textured.
[[nodiscard]] bool clear_of_other_objects(LabelView labels, const Eigen::Vector2f& position_px,
                                          std::uint8_t body) noexcept;

/// Whether at least two of the four sides of an object's feature are the object's own: else its patch holds mostly
/// background, which moves differently. Small and thin objects have little else.
[[nodiscard]] bool well_inside(LabelView labels, const Eigen::Vector2f& position_px, std::uint8_t body) noexcept;

/// The pixels of the patch around a position that are the body's own, off its contour: what lies on the other side of a
/// contour moves differently. The whole patch where too few are left to align it by.
[[nodiscard]] PatchMask own_pixels(LabelView labels, const Eigen::Vector2f& position_px, std::uint8_t body) noexcept;

}  // namespace kinetrace::features

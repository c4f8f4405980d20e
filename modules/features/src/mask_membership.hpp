// Whether a feature still belongs to its body, by the masks of the frame.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "kernel_types.hpp"
#include "kinetrace/core/image_view.hpp"

namespace kinetrace::features {

/// Borders of masks are a pixel or two off, so a feature keeps its body unless it lies `border_px` inside another one.
/// The ignore label ends it at once.
[[nodiscard]] bool still_member(LabelView labels, const Eigen::Vector2f& position_px, std::uint8_t body,
                                float border_px) noexcept;

/// False if a patch around an object's feature would contain much of another object: along a common contour a patch
/// follows the side with more texture.
[[nodiscard]] bool clear_of_other_objects(LabelView labels, const Eigen::Vector2f& position_px,
                                          std::uint8_t body) noexcept;

/// True if at least two of the four sides of an object's feature are the object's own; otherwise its patch is mostly
/// background, which moves differently. Small and thin objects have few other features.
[[nodiscard]] bool well_inside(LabelView labels, const Eigen::Vector2f& position_px, std::uint8_t body) noexcept;

/// The pixels of the patch around a position that are the body's own, off its contour: those beyond a contour move
/// differently. The whole patch if too few are left for alignment.
[[nodiscard]] PatchMask own_pixels(LabelView labels, const Eigen::Vector2f& position_px, std::uint8_t body) noexcept;

}  // namespace kinetrace::features

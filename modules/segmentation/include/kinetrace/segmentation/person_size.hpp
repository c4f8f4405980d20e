// The size of people in an image.
#pragma once

#include <cmath>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace::segmentation {

/// True for a box, pixels, whose diagonal at this disparity is longer than people are: 2 m tall, striding, with the
/// error of masks at the outline.
[[nodiscard]] inline bool is_larger_than_people(const PixelBox& box, float disparity_px, float baseline_m) noexcept {
  constexpr float kLargestPerson_m = 2.5F;
  return std::hypot(static_cast<float>(box.width()), static_cast<float>(box.height())) * baseline_m >=
         kLargestPerson_m * disparity_px;
}

}  // namespace kinetrace::segmentation

// Contrast of images across the outlines of masks: whether masks belong to the images that they came with.
#pragma once

#include <span>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/track_frame.hpp"

namespace kinetrace::segmentation {

/// Sums over outline points, in grey levels. Objects differ from what is behind them: masks of other images have the
/// contrast of any place, and masks of the right image have more contrast there than in the left one.
struct KINETRACE_API OutlineContrast {
  double points = 0.0;  ///< Number: where an outline of left masks crosses a row of the image.
  double left = 0.0;    ///< At these points of the left image.
  double right = 0.0;   ///< At these points of the right image.
  double beside = 0.0;  ///< In the left image, some pixels to their left and right; mean of four places.

  OutlineContrast& operator+=(const OutlineContrast& other) noexcept;
  OutlineContrast& operator*=(double weight) noexcept;
};

/// Of the tracks that were detected in this frame. `left_labels`: Track::label() per pixel, of
/// the pair's size. Never allocates; .08 ms for ten objects of 80x80 px.
[[nodiscard]] KINETRACE_API OutlineContrast outline_contrast(const RectifiedPair& pair, LabelView left_labels,
                                                             std::span<const Track> tracks) noexcept;

}  // namespace kinetrace::segmentation

// Images whose transfer broke off.
#pragma once

#include <array>
#include <optional>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/frame.hpp"

namespace kinetrace::hal {

/// Finds images whose end never arrived: the rows at the bottom are of one value throughout.
///
/// Pixels that arrived have noise: with half a grey level of it, a pixel equals its neighbour's value with a
/// probability below 0.7, so that a row of 64 pixels is flat by chance once in 10^10, and a wider one never. Three
/// things distinguish that from whole rows that are flat in an intact image. A border of the rectification, or a part
/// of the car, is there in every frame: only rows beyond the fewest flat ones so far count. A night or a glare is there
/// for both views: only rows in which the other view sees something count. And clipping sets in gradually: just above
/// the flat rows most pixels must be of another value. Two such rows are damage. Where a third of the image or more is
/// flat and the other view sees something there, that is damage from the first frame on and in every frame.
class KINETRACE_API CutOffDetector {
 public:
  struct Finding {
    bool is_left = false;
    int rows = 0;  ///< Missing at the bottom.
  };

  /// Of the next frame of a stream; none if both images look whole. Reads a few rows of them. The first frame has
  /// nothing to be compared with: less than a third that is missing there is not found.
  [[nodiscard]] std::optional<Finding> examine(const StereoFrame& frame) noexcept;

 private:
  std::array<std::optional<int>, 2> usual_rows_;  ///< Fewest flat rows so far, of either view.
};

}  // namespace kinetrace::hal

// Detects images whose transfer was cut off.
#pragma once

#include <array>
#include <optional>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/frame.hpp"

namespace kinetrace::hal {

/// Detects truncated images: their rows at the bottom have one single value.
///
/// Noise makes flat rows improbable: with noise of half a grey level, a pixel equals its neighbour with a probability
/// below 0.7, so a row of 64 pixels is flat by chance once in 10^10, and a wider one never. Flat rows of intact images
/// are excluded by three criteria:
/// - Borders of the rectification and parts of the vehicle appear in every frame: only rows beyond the smallest number
///   of flat rows so far count.
/// - Darkness and glare affect both views: only rows in which the other view has contrast count.
/// - Clipping sets in gradually: most pixels just above the flat rows must have another value.
///
/// Two remaining rows are damage. A flat area of a third of the image or more in which the other view has contrast is
/// damage in every frame, the first one included.
class KINETRACE_API CutOffDetector {
 public:
  struct Finding {
    bool is_left = false;
    int rows = 0;  ///< Missing at the bottom.
  };

  /// Examines the next frame of a stream; none if both images look intact. Reads a few rows of each. The first frame
  /// has no reference: there, less than a missing third is not detected.
  [[nodiscard]] std::optional<Finding> examine(const StereoFrame& frame) noexcept;

 private:
  std::array<std::optional<int>, 2> usual_rows_;  ///< Fewest flat rows so far, of either view.
};

}  // namespace kinetrace::hal

// Limits on a pipeline's work, for machines too slow for the full configuration.
#pragma once

#include <limits>

namespace kinetrace {

/// Upper bounds on top of the configuration. The default changes nothing, bit for bit.
struct Effort {
  int refinement_iterations = std::numeric_limits<int>::max();  ///< Of a body's bundle adjustment, per frame.
  double points = 1.0;                                          ///< Fraction of the configured features of each body.
  int objects = std::numeric_limits<int>::max();                ///< Tracks alive at once.

  [[nodiscard]] bool operator==(const Effort&) const noexcept = default;
};

}  // namespace kinetrace

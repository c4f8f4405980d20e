// How much of what it was configured for a pipeline does, for machines that are too slow for all of it.
#pragma once

#include <limits>

namespace kinetrace {

/// Upper bounds on top of the configuration. The default leaves everything as configured, bit for bit.
struct Effort {
  int refinement_iterations = std::numeric_limits<int>::max();  ///< Of a body's bundle adjustment, per frame.
  double points = 1.0;                                          ///< Part of the features that each body may have.
  int objects = std::numeric_limits<int>::max();                ///< Tracks alive at once.

  [[nodiscard]] bool operator==(const Effort&) const noexcept = default;
};

}  // namespace kinetrace

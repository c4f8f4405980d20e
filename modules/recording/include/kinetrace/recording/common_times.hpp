// Whether two lists of frames may be of one recording.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kinetrace/core/export.hpp"
#include "kinetrace/recording/run_reader.hpp"

namespace kinetrace::recording {

struct CommonTimes {
  std::size_t frames = 0;  ///< Of the shorter list.
  std::size_t common = 0;  ///< Times of the run's frames that are in both lists.

  /// Half of them or more.
  [[nodiscard]] bool are_most() const noexcept { return 2 * common >= frames; }
};

/// Compares the times of a run's frames with others, in any order.
[[nodiscard]] KINETRACE_API CommonTimes common_times(const Run& run, std::vector<std::int64_t> times_ns);

}  // namespace kinetrace::recording

// The one median.
#pragma once

#include <algorithm>
#include <cstddef>

namespace kinetrace {

/// The upper median of values, which there are: the element that half of them, rounded down, come before. Reorders
/// them.
template <typename Values>
[[nodiscard]] auto median(Values&& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace kinetrace

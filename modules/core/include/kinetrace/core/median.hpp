// The median, defined once.
#pragma once

#include <algorithm>
#include <cstddef>

namespace kinetrace {

/// The upper median of a non-empty range: element size / 2 in ascending order. Reorders the range.
template <typename Values>
[[nodiscard]] auto median(Values&& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace kinetrace

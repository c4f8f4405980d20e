// Quantiles: the median of values, and gates by chi-square.
#pragma once

#include <algorithm>
#include <cstddef>

namespace kinetrace {

/// 99.9 % quantiles of chi-square with two and three degrees of freedom.
inline constexpr double kChiSquareGate2 = 13.8;
inline constexpr double kChiSquareGate3 = 16.3;

/// The upper median of a non-empty range: element size / 2 in ascending order. Reorders the range.
template <typename Values>
[[nodiscard]] auto median(Values&& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace kinetrace

// Order statistics without allocation.
#pragma once

#include <algorithm>
#include <span>

namespace kinetrace::trajectory {

/// Standard deviation of a Gaussian over its median absolute deviation.
inline constexpr double kSigmaOverMad = 1.4826;

/// The element of rank `rank` in ascending order; reorders `values`, which are not empty.
template <typename T>
[[nodiscard]] T ranked(std::span<T> values, std::size_t rank) noexcept {
  const auto element = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), element, values.end());
  return *element;
}

/// The upper median; reorders `values`, which are not empty.
template <typename T>
[[nodiscard]] T median(std::span<T> values) noexcept {
  return ranked(values, values.size() / 2);
}

}  // namespace kinetrace::trajectory

// Even thinning of a sequence.
#pragma once

#include <algorithm>
#include <cstddef>

namespace kinetrace::publishing {

/// Keeps `most` of `total` items, evenly spread, or all if there are not more.
class Thinning {
 public:
  Thinning(std::size_t most, std::size_t total) noexcept : kept_(std::min(most, total)), total_(total) {}

  /// Call once for each item.
  [[nodiscard]] bool lets_through() noexcept {
    sum_ += kept_;
    if (sum_ < total_) {
      return false;
    }
    sum_ -= total_;
    return true;
  }
  [[nodiscard]] std::size_t kept() const noexcept { return kept_; }

 private:
  std::size_t kept_;
  std::size_t total_;
  std::size_t sum_ = 0;
};

}  // namespace kinetrace::publishing

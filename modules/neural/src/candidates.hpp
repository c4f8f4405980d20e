// Candidate boxes of a network, and non-maximum suppression.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/fixed_vector.hpp"

namespace kinetrace::neural {

/// Corners in pixels of the network's input.
struct Box {
  float x0 = 0.F;
  float y0 = 0.F;
  float x1 = 0.F;
  float y1 = 0.F;

  [[nodiscard]] static Box around(float x, float y, float width, float height) noexcept {
    return {x - width / 2.F, y - height / 2.F, x + width / 2.F, y + height / 2.F};
  }
  [[nodiscard]] float area() const noexcept { return x1 > x0 && y1 > y0 ? (x1 - x0) * (y1 - y0) : 0.F; }
};

/// Intersection over union; 0 for empty boxes.
[[nodiscard]] float overlap(const Box& a, const Box& b) noexcept;

/// A strided row of numbers in a tensor: mask coefficients, or the mask itself.
struct Strided {
  const float* first = nullptr;
  std::ptrdiff_t step = 1;
  [[nodiscard]] float operator[](std::size_t i) const noexcept { return first[static_cast<std::ptrdiff_t>(i) * step]; }
};

struct Candidate {
  Box box;
  float score = 0.F;
  int class_index = 0;
  Strided mask;  ///< Coefficients of the prototypes, or mask-rcnn's grid.
};

/// Keeps the strongest candidates, up to its capacity.
class CandidateList {
 public:
  CandidateList() = default;
  CandidateList(Arena& arena, std::size_t capacity) : candidates_(arena, capacity) {}

  void clear() noexcept {
    candidates_.clear();
    dropped_ = 0;
  }
  /// Skips boxes that are empty or not finite.
  void add(const Candidate& candidate) noexcept;
  /// Non-maximum suppression within each class: keeps the strongest, and none that overlaps a stronger one by more than
  /// `max_overlap`. Leaves the rest, strongest first.
  void suppress(float max_overlap) noexcept;

  [[nodiscard]] std::span<const Candidate> all() const noexcept { return candidates_.span(); }
  /// Number dropped since clear(), at capacity.
  [[nodiscard]] std::size_t dropped() const noexcept { return dropped_; }

 private:
  FixedVector<Candidate> candidates_;  ///< A heap, weakest first, until suppress().
  std::size_t dropped_ = 0;
};

}  // namespace kinetrace::neural

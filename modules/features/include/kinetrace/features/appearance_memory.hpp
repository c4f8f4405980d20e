// What the points of a body looked like, for recognising them when the body has been out of view.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"

namespace kinetrace::features {

/// A live feature whose place on its body is known.
struct KnownPoint {
  std::uint16_t slot = 0;  ///< Of the feature.
  Eigen::Vector3f p_body = Eigen::Vector3f::Zero();
};

/// Where a remembered point is expected: column and row in the left image, px.
using ExpectedObservation = Eigen::Vector2f;

/// What is taken for a remembered point.
struct RecognitionGate {
  Eigen::Vector2f reach_px{0.F, 0.F};  ///< So far from where it is expected, columns and rows.
  float min_similarity = 0.85F;        ///< Correlation of the two patches.
};

/// A remembered point found again.
struct RecognisedPoint {
  std::uint16_t slot = 0;   ///< Of the feature that looks like it.
  std::uint16_t point = 0;  ///< Its index in the memory.
  Eigen::Vector3f p_body = Eigen::Vector3f::Zero();
  Eigen::Vector2f left_px{0.F, 0.F};
  float v_px = 0.F;        ///< As Feature::v_px.
  float u_right_px = 0.F;  ///< As Feature::u_right_px.
};

/// Up to a capacity of points with the image around each. Filled and asked by FeatureFrontEnd.
class AppearanceMemory {
 public:
  AppearanceMemory() = default;
  /// Memory: 0.9 kB a point. The arena may turn out exhausted.
  AppearanceMemory(std::size_t capacity, Arena& arena);

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] const Eigen::Vector3f& p_body(std::size_t i) const noexcept;
  void clear() noexcept { size_ = 0; }
  void swap(AppearanceMemory& other) noexcept { std::swap(*this, other); }

 private:
  friend class FeatureFrontEnd;
  struct Entry;
  /// That of this feature, or else a free one, or the one noted longest ago; none if all are of the present note.
  [[nodiscard]] Entry* place_for(std::uint32_t feature_id) noexcept;
  Entry* entries_ = nullptr;  ///< In the arena.
  std::size_t capacity_ = 0;
  std::size_t size_ = 0;
  std::uint32_t notes_ = 0;  ///< Taken so far.
};

}  // namespace kinetrace::features

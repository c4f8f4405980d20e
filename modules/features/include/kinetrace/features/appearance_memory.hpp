// Appearance of a body's points, for re-identification after an occlusion.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"

namespace kinetrace::features {

/// A live feature with a known point of its body.
struct KnownPoint {
  std::uint16_t slot = 0;  ///< Of the feature.
  Eigen::Vector3f p_body = Eigen::Vector3f::Zero();
};

/// Where a remembered point is expected: column and row in the left image, px.
using ExpectedObservation = Eigen::Vector2f;

/// Gate for matches of remembered points.
struct RecognitionGate {
  Eigen::Vector2f reach_px{0.F, 0.F};  ///< Largest distance from the expected place, columns and rows.
  float min_similarity = 0.85F;        ///< Correlation of the two patches.
};

/// A remembered point found again.
struct RecognisedPoint {
  std::uint16_t slot = 0;   ///< Of the matching feature.
  std::uint16_t point = 0;  ///< Its index in the memory.
  Eigen::Vector3f p_body = Eigen::Vector3f::Zero();
  Eigen::Vector2f left_px{0.F, 0.F};
  float v_px = 0.F;        ///< As Feature::v_px.
  float u_right_px = 0.F;  ///< As Feature::u_right_px.
};

/// The image patches around up to a capacity of points. Filled and queried by FeatureFrontEnd.
class AppearanceMemory {
 public:
  AppearanceMemory() = default;
  /// Memory: 0.9 kB a point. The arena may be exhausted afterwards.
  AppearanceMemory(std::size_t capacity, Arena& arena);

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] const Eigen::Vector3f& p_body(std::size_t i) const noexcept;
  void clear() noexcept { size_ = 0; }
  void swap(AppearanceMemory& other) noexcept { std::swap(*this, other); }

 private:
  friend class FeatureFrontEnd;
  struct Entry;
  /// The entry of this feature, or else a free one, or the one noted longest ago; none if all are of the present note.
  [[nodiscard]] Entry* place_for(std::uint32_t feature_id) noexcept;
  Entry* entries_ = nullptr;  ///< In the arena.
  std::size_t capacity_ = 0;
  std::size_t size_ = 0;
  std::uint32_t notes_ = 0;  ///< Notes so far.
};

}  // namespace kinetrace::features

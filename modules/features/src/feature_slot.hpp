// Internal state of a live feature besides its published part.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "image_pyramid.hpp"
#include "kernel_types.hpp"
#include "kinetrace/core/feature_frame.hpp"

namespace kinetrace::features {

/// Surroundings of a feature when last (re-)referenced, wide enough for a warp to half the size.
class ReferencePatch {
 public:
  static constexpr int kWidth = 32;
  static constexpr int kHeight = 24;

  /// Copies the surroundings of (x, y).
  void take(const Plane& image, float x, float y) noexcept;

  [[nodiscard]] Plane plane() const noexcept { return {pixels_.data(), kWidth, kHeight, kWidth, 0}; }
  [[nodiscard]] float x() const noexcept { return x_; }
  [[nodiscard]] float y() const noexcept { return y_; }

 private:
  // Gathers read two bytes past the last pair they want.
  static constexpr std::size_t kSpill = 4;
  std::array<std::uint8_t, static_cast<std::size_t>(kWidth) * kHeight + kSpill> pixels_;
  float x_;
  float y_;
};

inline constexpr PatchWarp kNoWarp{1.F, 0.F, 0.F, 1.F};

[[nodiscard]] inline float largest_change(const PatchWarp& a, const PatchWarp& b) noexcept {
  return std::max({std::abs(a.xx - b.xx), std::abs(a.xy - b.xy), std::abs(a.yx - b.yx), std::abs(a.yy - b.yy)});
}

inline constexpr PatchMask kWholePatch{{}, true};

/// Smallest number of features worth another worker.
inline constexpr std::size_t kFeaturesAtOnce = 16;

enum class SlotState : std::uint8_t {
  kFree,
  kAlive,
  kDead,  ///< Ended in this frame: free from the next one.
};

struct FeatureSlot {
  SlotState state;
  bool rejected;
  PatchWarp from_reference;  ///< Offset in the reference patch = from_reference * offset in the current image.
  float zoom;                ///< Size in this frame over the size in the previous one.
  PatchWarp to_right;        ///< Offset in the left image = to_right * offset in the right image (surface slant).
  PatchMask own;             ///< Pixels around it that are its body's own, by the newest labels.
  Feature feature;
  ReferencePatch reference;

  /// Ends the feature and counts why.
  void end(std::uint64_t& reason) noexcept {
    state = SlotState::kDead;
    ++reason;
  }
};

}  // namespace kinetrace::features

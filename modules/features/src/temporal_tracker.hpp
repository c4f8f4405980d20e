// Tracks single features from the previous left image into the current one.
#pragma once

#include <Eigen/Core>

#include "feature_slot.hpp"
#include "image_pyramid.hpp"
#include "kinetrace/features/feature_config.hpp"
#include "patch_gate.hpp"

namespace kinetrace::features {

enum class TrackOutcome : std::uint8_t { kTracked, kReReferenced, kOutside, kTexture, kResidual, kForwardBackward };

[[nodiscard]] constexpr bool succeeded(TrackOutcome outcome) noexcept {
  return outcome == TrackOutcome::kTracked || outcome == TrackOutcome::kReReferenced;
}

/// Search range around a feature's start.
enum class Reach : std::uint8_t {
  kNear,    ///< About five pixels.
  kWide,    ///< About ten.
  kSearch,  ///< 64 x 48, by exhaustive search at the coarsest level.
};

/// Initial values of a track step.
struct TrackStart {
  Eigen::Vector2f position_px{0.F, 0.F};
  Reach reach = Reach::kNear;
  float zoom = 1.F;  ///< Expected size over the size in the previous frame.
};

class TemporalTracker {
 public:
  TemporalTracker() = default;
  explicit TemporalTracker(const FeatureConfig& config) : config_(config) {}

  /// Moves `slot.feature.left_px` from `previous` to `current`; unchanged, like the rest of the slot, on failure.
  [[nodiscard]] TrackOutcome follow(const ImagePyramid& previous, const ImagePyramid& current, const TrackStart& start,
                                    FeatureSlot& slot) const noexcept;

 private:
  struct Refined;
  [[nodiscard]] Eigen::Vector2f approach(const ImagePyramid& previous, const ImagePyramid& current,
                                         const Eigen::Vector2f& from, const TrackStart& start) const noexcept;
  [[nodiscard]] Refined refine_against_reference(const Plane& current, const Eigen::Vector2f& near, float zoom,
                                                 const PatchGate& gate, const FeatureSlot& slot) const noexcept;
  [[nodiscard]] Refined refine_against_previous(const Plane& previous, const Plane& current,
                                                const Eigen::Vector2f& from, const Eigen::Vector2f& near, float zoom,
                                                const PatchGate& gate, const PatchMask& own) const noexcept;
  [[nodiscard]] bool returns(const Plane& previous, const Plane& current, const Eigen::Vector2f& from,
                             const Eigen::Vector2f& start, const Refined& found, const PatchMask& own) const noexcept;

  FeatureConfig config_;
};

}  // namespace kinetrace::features

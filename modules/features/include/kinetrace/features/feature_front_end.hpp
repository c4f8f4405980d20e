// Correspondences of a stereo video: corners per body, tracked left -> next left, matched left -> right.
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/rig_correction.hpp"
#include "kinetrace/core/workers.hpp"
#include "kinetrace/features/feature_config.hpp"

namespace kinetrace::features {

/// Running totals since create or reset.
struct FeatureCounters {
  std::uint64_t tracked = 0;        ///< Features carried from one frame to the next.
  std::uint64_t recovered = 0;      ///< Of these, at the second attempt.
  std::uint64_t re_referenced = 0;  ///< Of these, given a new reference patch.
  std::uint64_t created = 0;
  std::uint64_t dropped = 0;  ///< Corners not taken because a capacity was reached.
  std::uint64_t stereo_attempted = 0;
  std::uint64_t stereo_matched = 0;
  std::uint64_t lost_outside = 0;   ///< Patch left the image.
  std::uint64_t lost_texture = 0;   ///< Too little texture to be tracked.
  std::uint64_t lost_residual = 0;  ///< Patch differs too much from its template.
  std::uint64_t lost_forward_backward = 0;
  std::uint64_t lost_body = 0;     ///< Now in another body's mask, or under the ignore label.
  std::uint64_t rejected = 0;      ///< By the caller.
  std::uint64_t lost_crowded = 0;  ///< Two features met: the younger one ends.
  std::uint64_t lost_limit = 0;    ///< Beyond `limit`.

  /// All features that ended.
  [[nodiscard]] std::uint64_t lost() const noexcept {
    return lost_outside + lost_texture + lost_residual + lost_forward_backward + lost_body + rejected + lost_crowded +
           lost_limit;
  }
};

/// Correction of a pair's right image.
struct RigAdjustment {
  RigCorrection correction;  ///< Applied to the right image and its measurements.
  /// The calibration may be wrong: if few features match in their row, other rows are searched, too.
  bool may_be_off = false;
  const RigChange* change = nullptr;  ///< Since the frame before; null if unchanged.
};

/// Finds, tracks and stereo-matches features (METHOD: correspondences). One frame is `begin_frame`, `track`,
/// `replenish`, in this order; `reject` at any time. Ids are never reused; a slot is stable while its feature lives and
/// is reused from the frame after its death. A feature's body never changes: the feature ends instead.
///
/// Temporal: inverse-compositional Lucas-Kanade (Baker and Matthews 2004), 16 x 11 patch, invariant to gain and offset,
/// coarse to fine; the last step aligns with the feature's reference patch under an affine warp, so that drift does not
/// accumulate. Left-right: row search on horizontal gradients with left-right check, then the same alignment with the
/// surface's slant; v is the mean row of the pair. Both end with an alignment of the patch's centre alone: at contours
/// its rim belongs to another surface.
class FeatureFrontEnd {
 public:
  /// Memory: pyramids of two left images, the right image and the gradients of a pair (about 7 bytes a pixel), and 1.1
  /// kB a feature: 4.9 MB for the defaults at 1242 x 375.
  /// `workers` share the work and outlive this; null: the caller does it alone, with the same result.
  /// Errors: kInvalidConfig, kInvalidArgument (image smaller than 64 x 48), kCapacity (arena too small).
  [[nodiscard]] static Result<FeatureFrontEnd> create(const FeatureConfig& config, int width_px, int height_px,
                                                      Arena& arena, Workers* workers = nullptr);
  /// Bytes that `create` takes from the arena.
  [[nodiscard]] static std::size_t required_bytes(const FeatureConfig& config, int width_px, int height_px);

  /// Copies the pair and builds the pyramids; dead slots become free.
  /// Errors: kInvalidArgument when the size differs from create's.
  [[nodiscard]] Status begin_frame(const RectifiedPair& pair, const RigAdjustment& rig = {});
  /// Right image of this frame, corrected. Lives until the next `begin_frame`.
  [[nodiscard]] GrayView right_image() const noexcept;
  /// True if the row search began with this frame: rows and disparities of features change.
  [[nodiscard]] bool row_search_began() const noexcept;

  /// Tracks every live feature from the previous frame into this one and matches it left-right. `by_slot[s]` is the
  /// prediction for slot s; a shorter span means unknown for the rest. Outliers passed to `reject` end here. The span
  /// of the result lives until the next call. Errors: kIllegalState without `begin_frame`.
  [[nodiscard]] Result<FeatureFrame> track(std::span<const FeaturePrediction> by_slot);

  /// Between `track` and `replenish`: number of buckets of the background's grid with a corner in this frame, with or
  /// without a feature. Takes as long as detection.
  [[nodiscard]] std::size_t count_corners() noexcept;

  /// Labels of bodies with predicted masks: existing features stay, but no new ones are detected.
  using PredictedMasks = std::bitset<256>;

  /// Reconciles features with the masks and detects new ones in free buckets. Empty `left_labels`: all is background.
  /// The result holds all live features, in ascending slot. Errors: kIllegalState without `track`, kInvalidArgument
  /// when the size of the labels differs.
  [[nodiscard]] Result<FeatureFrame> replenish(LabelView left_labels, const PredictedMasks& predicted = {});

  /// Marks outliers by slot; their features end at the next `track`. Slots not alive are ignored.
  void reject(std::span<const std::uint16_t> slots) noexcept;

  /// From the next `replenish` on, limits each body to this part, in (0, 1], of its configured features. The youngest
  /// beyond it end.
  void limit(double part) noexcept;

  [[nodiscard]] const FeatureCounters& counters() const noexcept;

  /// Drops all features and counters, as after create. Ids continue.
  void reset() noexcept;

  FeatureFrontEnd(FeatureFrontEnd&&) noexcept = default;
  FeatureFrontEnd& operator=(FeatureFrontEnd&&) noexcept = default;
  FeatureFrontEnd(const FeatureFrontEnd&) = delete;
  FeatureFrontEnd& operator=(const FeatureFrontEnd&) = delete;
  ~FeatureFrontEnd() = default;

 private:
  struct State;
  explicit FeatureFrontEnd(State& state) noexcept : state_(&state) {}
  State* state_;  ///< In the arena.
};

}  // namespace kinetrace::features

#include "temporal_tracker.hpp"

#include <algorithm>
#include <cmath>

#include "centre_alignment.hpp"
#include "kernels.hpp"
#include "patch_gate.hpp"

namespace kinetrace::features {
namespace {

using Eigen::Vector2f;

// Alignment reaches a few pixels at its first level. Small objects fill little of a patch on coarse levels, so the
// finest sufficient level is best.
constexpr int kNearTopLevel = 1;
constexpr int kWideTopLevel = 2;
constexpr float kFarCorrelation = 0.9F;
// Search range in the full-size image.
constexpr int kSearchX_px = 64;
constexpr int kSearchY_px = 48;
constexpr AlignOptions kCoarse{
    .max_iterations = 6, .converged_px = 0.1F, .max_shift_px = 6.F, .preferred_row = 0.F, .row_weight = 0.F};
constexpr AlignOptions kFine{
    .max_iterations = 10, .converged_px = 0.02F, .max_shift_px = 5.F, .preferred_row = 0.F, .row_weight = 0.F};
// Only compared with a gate of about a pixel.
constexpr AlignOptions kBackward{
    .max_iterations = 8, .converged_px = 0.05F, .max_shift_px = 5.F, .preferred_row = 0.F, .row_weight = 0.F};
// The backward pass starts off the known answer by this much, or it would prove nothing.
constexpr float kBackwardOffset_px = 1.5F;
// Prior of a warp: standard deviation of the change of its matrix per frame, under gray noise of this size.
constexpr float kWarpSigma = 0.03F;
constexpr float kNoise_gray = 2.5F;
constexpr WarpOptions kWarpOptions{.prior_weight = kNoise_gray * kNoise_gray / (kWarpSigma * kWarpSigma),
                                   .horizontal_only = false};

// Another pass follows if the warp moved the patch's corners by more than a fifth of a pixel.
constexpr int kReferencePasses = 3;
constexpr float kConvergedWarp = 0.03F;

float determinant(const PatchWarp& warp) noexcept {
  return warp.xx * warp.yy - warp.xy * warp.yx;
}

PatchWarp scaled(const PatchWarp& warp, float factor) noexcept {
  return {factor * warp.xx, factor * warp.xy, factor * warp.yx, factor * warp.yy};
}

/// A reference is obsolete beyond half or twice its size, or when strongly sheared.
bool plausible(const PatchWarp& warp) noexcept {
  const float product = determinant(warp);
  const float squares = warp.xx * warp.xx + warp.xy * warp.xy + warp.yx * warp.yx + warp.yy * warp.yy;
  // For singular values a, b: product = ab, squares = a^2 + b^2.
  return product > 0.35F && product < 2.2F && squares < 2.6F * product;
}

Vector2f level_position(const Vector2f& full, int level) noexcept {
  return {to_level(full.x(), level), to_level(full.y(), level)};
}

/// The patch around `position`, scaled by `zoom`.
bool sample_zoomed(const Plane& image, const Vector2f& position, float zoom, const PatchMask& own,
                   PatchTemplate& patch) noexcept {
  // A smaller zoom moves no sample by a quarter of a pixel.
  constexpr float kNoticeable = 0.03F;
  if (std::abs(zoom - 1.F) < kNoticeable) {
    kernels().patch_template.sample(image, position.x(), position.y(), own, &patch);
    return true;
  }
  return kernels().patch_template.sample_warped(image, position.x(), position.y(), {1.F / zoom, 0.F, 0.F, 1.F / zoom},
                                                own, &patch);
}

/// Aligns the patch of `source` around `from` with `target`, starting at `guess`. Returns the guess on failure.
Vector2f aligned(const Plane& source, const Plane& target, const Vector2f& from, const Vector2f& guess, float zoom,
                 const PatchMask& own, const AlignOptions& options) noexcept {
  PatchTemplate patch;
  Vector2f position = guess;
  return sample_zoomed(source, from, zoom, own, patch) &&
                 kernels().patch.align(target, patch, options, &position.x(), &position.y())
             ? position
             : guess;
}

/// Exhaustive search at the coarsest level.
Vector2f search(const ImagePyramid& previous, const ImagePyramid& current, const Vector2f& from,
                const Vector2f& around) noexcept {
  const int level = current.levels() - 1;
  const Plane image = current.level(level);
  const Vector2f at = level_position(from, level);
  PatchTemplate patch;
  kernels().patch_template.sample(previous.level(level), at.x(), at.y(), kWholePatch, &patch);
  const Vector2f centre = level_position(around, level);
  const int x = std::clamp(static_cast<int>(std::floor(centre.x())), 0, image.width - 1);
  const int y = std::clamp(static_cast<int>(std::lround(centre.y())), 0, image.height - 1);
  const OffsetMatch match =
      kernels().search.correlate(image, patch, x, y, std::clamp(kSearchX_px >> level, 1, kMaxSearchRadius),
                                 std::clamp(kSearchY_px >> level, 1, kMaxSearchRadius));
  return {from_level(static_cast<float>(x + match.dx) + 0.5F, level),
          from_level(static_cast<float>(y + match.dy), level)};
}

bool contains(const Plane& image, const Vector2f& position) noexcept {
  return position.x() >= 0.F && position.y() >= 0.F && position.x() <= static_cast<float>(image.width - 1) &&
         position.y() <= static_cast<float>(image.height - 1);
}

}  // namespace

struct TemporalTracker::Refined {
  TrackOutcome outcome = TrackOutcome::kResidual;
  Vector2f position_px{0.F, 0.F};
  PatchWarp warp = kNoWarp;  ///< From the reference.
  float zoom = 1.F;
};

TrackOutcome TemporalTracker::follow(const ImagePyramid& previous, const ImagePyramid& current, const TrackStart& start,
                                     FeatureSlot& slot) const noexcept {
  const Plane image = current.level(0);
  const Vector2f from = slot.feature.left_px;
  if (!contains(image, start.position_px)) {
    return TrackOutcome::kOutside;
  }
  const Vector2f near = approach(previous, current, from, start);
  if (!contains(image, near)) {
    return TrackOutcome::kOutside;
  }

  // The larger the search range, the more similar places by chance.
  const PatchGate gate{
      start.reach == Reach::kNear ? config_.min_correlation : std::max(config_.min_correlation, kFarCorrelation),
      config_.max_residual};
  Refined refined;
  if (config_.refine_against_reference) {
    refined = refine_against_reference(image, near, start.zoom, gate, slot);
  }
  const bool referenced = refined.outcome == TrackOutcome::kTracked;
  if (!referenced) {
    refined = refine_against_previous(previous.level(0), image, from, near, start.zoom, gate, slot.own);
    if (!succeeded(refined.outcome)) {
      return refined.outcome;
    }
  }
  if (!returns(previous.level(0), image, from, start.position_px, refined, slot.own)) {
    return TrackOutcome::kForwardBackward;
  }

  slot.feature.left_px = refined.position_px;
  slot.from_reference = refined.warp;
  slot.zoom = refined.zoom;
  if (referenced && plausible(refined.warp)) {
    return TrackOutcome::kTracked;
  }
  slot.reference.take(image, refined.position_px.x(), refined.position_px.y());
  slot.from_reference = kNoWarp;
  return TrackOutcome::kReReferenced;
}

Vector2f TemporalTracker::approach(const ImagePyramid& previous, const ImagePyramid& current, const Vector2f& from,
                                   const TrackStart& start) const noexcept {
  const int coarsest = current.levels() - 1;
  Vector2f guess = start.position_px;
  int level = std::min(start.reach == Reach::kNear ? kNearTopLevel : kWideTopLevel, coarsest);
  if (start.reach == Reach::kSearch) {
    guess = search(previous, current, from, guess);
    level = coarsest;
  }
  for (; level > 0; --level) {
    const Vector2f position = aligned(previous.level(level), current.level(level), level_position(from, level),
                                      level_position(guess, level), start.zoom, kWholePatch, kCoarse);
    guess = {from_level(position.x(), level), from_level(position.y(), level)};
  }
  return guess;
}

TemporalTracker::Refined TemporalTracker::refine_against_reference(const Plane& current, const Vector2f& near,
                                                                   float zoom, const PatchGate& gate,
                                                                   const FeatureSlot& slot) const noexcept {
  Refined result;
  result.warp = scaled(slot.from_reference, 1.F / zoom);
  result.position_px = near;
  PatchFit fit{};
  PatchTemplate patch;
  for (int pass = 0; pass < kReferencePasses; ++pass) {
    if (!kernels().patch_template.sample_warped(slot.reference.plane(), slot.reference.x(), slot.reference.y(),
                                                result.warp, slot.own, &patch) ||
        patch.strength < config_.min_patch_strength ||
        !kernels().patch.align(current, patch, kFine, &result.position_px.x(), &result.position_px.y()) ||
        !patch_inside(current, result.position_px)) {
      return result;
    }
    const PatchWarp before = result.warp;
    fit = kernels().patch.refine_warp(current, patch, result.position_px.x(), result.position_px.y(), kWarpOptions,
                                      &result.warp);
    if (largest_change(before, result.warp) < kConvergedWarp) {
      break;
    }
  }
  if (looks_alike(fit, gate)) {
    align_centre(current, kFine, patch, result.position_px);
    result.outcome = TrackOutcome::kTracked;
    result.zoom = std::sqrt(std::abs(determinant(slot.from_reference) / determinant(result.warp)));
  }
  return result;
}

TemporalTracker::Refined TemporalTracker::refine_against_previous(const Plane& previous, const Plane& current,
                                                                  const Vector2f& from, const Vector2f& near,
                                                                  float zoom, const PatchGate& gate,
                                                                  const PatchMask& own) const noexcept {
  Refined result;
  result.zoom = zoom;
  PatchTemplate patch;
  if (!sample_zoomed(previous, from, zoom, own, patch) || patch.strength < config_.min_patch_strength) {
    result.outcome = TrackOutcome::kTexture;
    return result;
  }
  result.position_px = near;
  if (!kernels().patch.align(current, patch, kFine, &result.position_px.x(), &result.position_px.y())) {
    return result;
  }
  if (!patch_inside(current, result.position_px)) {
    result.outcome = TrackOutcome::kOutside;
    return result;
  }
  if (looks_alike(kernels().patch.fit(current, patch, result.position_px.x(), result.position_px.y()), gate)) {
    align_centre(current, kFine, patch, result.position_px);
    result.outcome = TrackOutcome::kTracked;
  }
  return result;
}

bool TemporalTracker::returns(const Plane& previous, const Plane& current, const Vector2f& from, const Vector2f& start,
                              const Refined& found, const PatchMask& own) const noexcept {
  // Offset in the direction of the forward start, to detect a match that merely stays at its start.
  const Vector2f error = found.position_px - start;
  const float length = error.norm();
  const Vector2f direction = length > 1e-3F ? Vector2f(error / length) : Vector2f(1.F, 0.F);
  const Vector2f back = aligned(current, previous, found.position_px, from + kBackwardOffset_px * direction,
                                1.F / found.zoom, own, kBackward);
  return (back - from).squaredNorm() <= config_.forward_backward_px * config_.forward_backward_px;
}

}  // namespace kinetrace::features

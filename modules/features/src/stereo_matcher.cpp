#include "stereo_matcher.hpp"

#include <algorithm>
#include <cmath>

#include "centre_alignment.hpp"
#include "kernels.hpp"
#include "patch_gate.hpp"

namespace kinetrace::features {
namespace {

constexpr int kMaxDisparity = 256;
// Disparities are not negative, but a minimum at zero needs a neighbour on its other side.
constexpr int kMinDisparity = -2;
constexpr int kMaxCosts = kMaxDisparity - 2 * kMinDisparity + 1;
// Lower bound of a cost: a gray level and a half of noise a pixel.
constexpr float kNoiseCost = 1.5F * static_cast<float>(kPatchPixels);
// Costs this near the best one belong to the same minimum.
constexpr int kMinimumHalfWidth = 3;
// Around an expected disparity: a fixed and a relative part.
constexpr float kNarrow_px = 4.F;
constexpr float kNarrowRatio = 0.08F;
// Rows to try for a new feature without a match in its own: the patch tolerates about one row on either side.
constexpr std::array<int, 3> kRowOffsets{0, -2, 2};
// ... and rows within about half a degree, when hardly any feature matches in its row.
constexpr std::array<int, 13> kFarRowOffsets{0, -2, 2, -4, 4, -6, 6, -8, 8, -10, 10, -12, 12};
constexpr float kFarRowDifference_px = 13.F;

// Rectification is good to about half a pixel; strong texture overrules this prior.
constexpr float kNoise_gray = 2.5F;
constexpr float kRowSigma_px = 0.5F;
constexpr AlignOptions kAlign{.max_iterations = 8,
                              .converged_px = 0.02F,
                              .max_shift_px = 4.F,
                              .preferred_row = 0.F,
                              .row_weight = kNoise_gray * kNoise_gray / (kRowSigma_px * kRowSigma_px)};
constexpr float kSlantSigma = 0.1F;
constexpr WarpOptions kSlantOptions{.prior_weight = kNoise_gray * kNoise_gray / (kSlantSigma * kSlantSigma),
                                    .horizontal_only = true};
constexpr int kPassesKnown = 1;
constexpr int kPassesNew = 3;
// Change of the slant (times 7.5: px at the patch's corners) below which another pass is not worth it.
constexpr float kConvergedSlant = 0.03F;
// With a more oblique surface the two images differ too much.
constexpr float kMinWidthRatio = 0.5F;
constexpr float kMaxWidthRatio = 2.F;
constexpr float kMaxShear = 1.F;

using Costs = std::array<std::uint16_t, kMaxCosts>;

int index_of_least(const Costs& costs, int count) noexcept {
  return static_cast<int>(std::min_element(costs.begin(), costs.begin() + count) - costs.begin());
}

/// Cost at the sub-pixel minimum: two lines of opposite slope through the three costs around it, the shape of a sum of
/// absolute differences.
float interpolated_minimum(const Costs& costs, int count, int i) noexcept {
  const auto cost = [&](int k) {
    return static_cast<float>(costs[static_cast<std::size_t>(std::clamp(k, 0, count - 1))]);
  };
  return cost(i) - 0.5F * std::abs(cost(i + 1) - cost(i - 1));
}

/// True if no other minimum comes near the best one; repetitive texture has many.
bool stands_out(const Costs& costs, int count, int best, float ratio) noexcept {
  const float limit = ratio * std::max(interpolated_minimum(costs, count, best), kNoiseCost);
  const auto competes = [&](int i) {
    return std::abs(i - best) > kMinimumHalfWidth && interpolated_minimum(costs, count, i) < limit;
  };
  for (int i = 0; i < count; ++i) {
    if (competes(i)) {
      return false;
    }
  }
  return true;
}

}  // namespace

bool StereoMatcher::match(const StereoImages& images, float expected_disparity_px, FeatureSlot& slot) const noexcept {
  Feature& feature = slot.feature;
  feature.u_right_px = kNoRight;
  feature.v_px = feature.left_px.y();
  const int x = static_cast<int>(std::floor(feature.left_px.x()));
  int disparity = 0;
  if (expected_disparity_px >= 0.F) {
    const float reach = kNarrow_px + kNarrowRatio * expected_disparity_px;
    const Range near = clipped(expected_disparity_px - reach, expected_disparity_px + reach, x);
    const int row_offset = known_row_offset(feature);
    if (search(images, feature, near, row_offset, false, disparity) &&
        refine(images, disparity, row_offset, kPassesKnown, slot)) {
      return true;
    }
  }
  const Range all =
      clipped(static_cast<float>(kMinDisparity), static_cast<float>(config_.max_disparity_px - kMinDisparity), x);
  slot.to_right = kNoWarp;
  const std::span<const int> rows = row_offsets(feature);
  return std::any_of(rows.begin(), rows.end(), [&](int row_offset) {
    return std::abs(static_cast<float>(row_offset)) <= max_row_difference_px() &&
           search(images, feature, all, row_offset, true, disparity) &&
           refine(images, disparity, row_offset, kPassesNew, slot);
  });
}

void StereoMatcher::set_rig(const StereoGeometry& geometry, const RigCorrection& correction,
                            bool rows_unknown) noexcept {
  geometry_ = geometry;
  correction_ = correction;
  rows_unknown_ = rows_unknown;
}

std::span<const int> StereoMatcher::row_offsets(const Feature& feature) const noexcept {
  if (rows_unknown_) {
    return kFarRowOffsets;
  }
  return std::span<const int>(kRowOffsets).first(feature.age_frames == 0 ? kRowOffsets.size() : 1);
}

int StereoMatcher::known_row_offset(const Feature& feature) const noexcept {
  return rows_unknown_ && feature.had_right()
             ? static_cast<int>(std::lround(2.F * (feature.previous_v_px - feature.previous_left_px.y())))
             : 0;
}

float StereoMatcher::max_row_difference_px() const noexcept {
  return rows_unknown_ ? kFarRowDifference_px : config_.max_row_difference_px;
}

StereoMatcher::Range StereoMatcher::clipped(float from, float to, int x) const noexcept {
  const auto least = static_cast<float>(kMinDisparity);
  const auto most = static_cast<float>(config_.max_disparity_px - kMinDisparity);
  // Keep the right patch inside the image.
  return {static_cast<int>(std::floor(std::clamp(from, least, most))),
          std::min(static_cast<int>(std::ceil(std::clamp(to, least, most))), x - kPatchWidth / 2)};
}

bool StereoMatcher::search(const StereoImages& images, const Feature& feature, Range range, int row_offset, bool unique,
                           int& disparity) const noexcept {
  constexpr int kMinCosts = 3;
  const int count = range.count();
  if (count < kMinCosts) {
    return false;
  }
  const int x = static_cast<int>(std::floor(feature.left_px.x()));
  const int y = static_cast<int>(std::lround(feature.left_px.y()));
  const int right_y = std::clamp(y + row_offset, 0, images.right.height - 1);
  // Columns ascend while disparities descend.
  Costs costs;
  kernels().search.row_costs(images.left_gradient, x, y, images.right_gradient, right_y, x - range.last, count,
                             costs.data());
  const int best = index_of_least(costs, count);
  // A minimum at the end of the range belongs to one outside.
  if (best == 0 || best == count - 1 || (unique && !stands_out(costs, count, best, config_.uniqueness_ratio))) {
    return false;
  }
  const int right_x = x - range.last + best;
  disparity = x - right_x;

  const int back_first = right_x + range.first;
  const int back_last = std::min(right_x + range.last, images.left.width - 1 - kPatchWidth / 2);
  if (back_last < back_first) {
    return false;
  }
  const int back_count = back_last - back_first + 1;
  kernels().search.row_costs(images.right_gradient, right_x, right_y, images.left_gradient, y, back_first, back_count,
                             costs.data());
  return std::abs(back_first + index_of_least(costs, back_count) - x) <= 1;
}

bool StereoMatcher::refine(const StereoImages& images, int disparity, int row_offset, int passes,
                           FeatureSlot& slot) const noexcept {
  Feature& feature = slot.feature;
  AlignOptions options = kAlign;
  options.preferred_row = feature.left_px.y();
  if (rows_unknown_) {
    options.row_weight = 0.F;
  }
  PatchWarp warp = slot.to_right;
  Eigen::Vector2f right =
      feature.left_px + Eigen::Vector2f(-static_cast<float>(disparity), static_cast<float>(row_offset));
  PatchFit fit{};
  PatchTemplate patch;
  for (int pass = 0; pass < passes; ++pass) {
    if (!kernels().patch_template.sample_warped(images.left, feature.left_px.x(), feature.left_px.y(), warp, slot.own,
                                                &patch) ||
        !kernels().patch.align(images.right, patch, options, &right.x(), &right.y()) ||
        !patch_inside(images.right, right)) {
      return false;
    }
    const PatchWarp before = warp;
    fit = kernels().patch.refine_warp(images.right, patch, right.x(), right.y(), kSlantOptions, &warp);
    if (largest_change(before, warp) < kConvergedSlant) {
      break;
    }
  }
  if (!looks_alike(fit, {config_.min_correlation, config_.max_residual})) {
    return false;
  }
  align_centre(images.right, options, patch, right);
  const float refined_disparity = feature.left_px.x() - right.x();
  if (refined_disparity < config_.min_disparity_px ||
      refined_disparity > static_cast<float>(config_.max_disparity_px) ||
      std::abs(right.y() - feature.left_px.y()) > max_row_difference_px()) {
    return false;
  }
  if (!correction_.baseline_rad.isZero(0.0)) {
    right -= correction_.baseline_shift_px(geometry_, right.cast<double>(), static_cast<double>(refined_disparity))
                 .cast<float>();
  }
  const bool plausible = warp.xx > kMinWidthRatio && warp.xx < kMaxWidthRatio && std::abs(warp.xy) < kMaxShear;
  slot.to_right = plausible ? warp : kNoWarp;
  feature.u_right_px = right.x();
  feature.v_px = 0.5F * (feature.left_px.y() + right.y());
  return true;
}

}  // namespace kinetrace::features
